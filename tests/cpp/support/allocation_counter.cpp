#include "support/allocation_counter.hpp"

#include <cstdlib>
#include <limits>
#include <new>

namespace {

thread_local std::size_t count = 0;
thread_local std::size_t bytes = 0;
thread_local std::ptrdiff_t live = 0;
thread_local std::size_t left = std::numeric_limits<std::size_t>::max();

bool may_allocate() noexcept {
  if (left == std::numeric_limits<std::size_t>::max()) return true;
  return left > 0 && left-- > 0;
}

void note(std::size_t size) noexcept {
  ++count;
  bytes += size;
  ++live;
}

void release(void* memory) noexcept {
  live -= memory == nullptr ? 0 : 1;
  std::free(memory);
}

void* counted(std::size_t size) {
  if (!may_allocate()) throw std::bad_alloc();
  note(size);
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

void* counted(std::size_t size, std::align_val_t alignment) {
  if (!may_allocate()) throw std::bad_alloc();
  note(size);
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}

}  // namespace

std::size_t asap::test::allocations() noexcept { return count; }
std::size_t asap::test::allocated_bytes() noexcept { return bytes; }
std::ptrdiff_t asap::test::live_allocations() noexcept { return live; }
asap::test::LastAllocations::LastAllocations(std::size_t more) noexcept { left = more; }
asap::test::LastAllocations::~LastAllocations() { left = std::numeric_limits<std::size_t>::max(); }

// All forms, the array ones too: a sanitizer brings its own of those that are left out, and memory
// of one family would come to the delete of the other.
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  void* const memory = may_allocate() ? std::malloc(size == 0 ? 1 : size) : nullptr;
  if (memory != nullptr) note(size);
  return memory;
}
void* operator new[](std::size_t size, const std::nothrow_t& tag) noexcept {
  return operator new(size, tag);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return counted(size, alignment);
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
