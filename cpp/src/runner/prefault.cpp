#include "runner/prefault.hpp"

#include <cstddef>
#include <cstdint>

#if defined(__linux__)
#include <link.h>
#endif

namespace asap::inline v0_1 {
namespace {

constexpr std::size_t kSmallestPage = 4096;

#if defined(__linux__)
// Between the objects of a page there may be what a sanitizer guards.
[[gnu::no_sanitize_address]] void read_pages(std::uintptr_t begin, std::size_t size) noexcept {
  const auto* const bytes = reinterpret_cast<const volatile unsigned char*>(begin);
  for (std::size_t at = 0; at < size; at += kSmallestPage) static_cast<void>(bytes[at]);
}

int read_if_ours(dl_phdr_info* object, std::size_t, void*) noexcept {
  const auto here = reinterpret_cast<std::uintptr_t>(&touch_code);
  const auto* const end = object->dlpi_phdr + object->dlpi_phnum;
  bool is_ours = false;
  for (const auto* part = object->dlpi_phdr; part != end; ++part) {
    const std::uintptr_t begin = object->dlpi_addr + part->p_vaddr;
    is_ours |= part->p_type == PT_LOAD && here - begin < part->p_memsz;
  }
  if (!is_ours) return 0;
  for (const auto* part = object->dlpi_phdr; part != end; ++part) {
    if (part->p_type != PT_LOAD || (part->p_flags & PF_R) == 0) continue;
    read_pages(object->dlpi_addr + part->p_vaddr, part->p_filesz);
  }
  return 1;
}
#endif

}  // namespace

void touch_code() noexcept {
#if defined(__linux__)
  dl_iterate_phdr(read_if_ours, nullptr);
#endif
}

[[gnu::noinline]] void touch_stack() noexcept {
  constexpr std::size_t kBytes = 64 * 1024;
  [[maybe_unused]] volatile std::byte stack[kBytes];
  for (std::size_t at = 0; at < kBytes; at += kSmallestPage) stack[at] = std::byte{0};
}

}  // namespace asap::inline v0_1
