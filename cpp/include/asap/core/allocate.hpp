// Memory whose size the user has chosen, allocated once, at construction. Where it cannot be had
// the error names the field, the value and the remedy, as that of require() does. The memory is not
// initialised, so its pages cost nothing until they are used. The throw is out of line.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

namespace asap {

// MemoryError in Python.
class NoMemory : public std::bad_alloc {
 public:
  explicit NoMemory(const std::string& message) : message_(message) {}
  const char* what() const noexcept override { return message_.what(); }

 private:
  std::runtime_error message_;  // a string whose copy does not throw
};

// Throws NoMemory("<field> = <value>: needs ... of memory, which cannot be had; choose less").
[[noreturn]] void throw_no_memory(std::string_view field, std::size_t value, double bytes);

// So many values, as the field with this value asks for.
template <class Value>
std::unique_ptr<Value[]> allocate(std::size_t count, std::string_view field, std::size_t value) {
  constexpr std::size_t kMost = std::numeric_limits<std::ptrdiff_t>::max() / sizeof(Value);
  Value* const memory = count <= kMost ? new (std::nothrow) Value[count] : nullptr;
  if (memory == nullptr) {
    throw_no_memory(field, value, static_cast<double>(count) * sizeof(Value));
  }
  return std::unique_ptr<Value[]>(memory);
}

}  // namespace asap
