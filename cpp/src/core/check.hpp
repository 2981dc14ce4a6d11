// Checks of a constructor: its configuration's values, and memory of a size that the user has
// chosen. The throws are out of line, so headers compile with -fno-exceptions too. Any thread.
#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <string_view>

#include "asap/core/result.hpp"

namespace asap::inline v0_1 {

// Throws a BadValue without a unit.
[[noreturn]] void throw_bad_value(std::string_view field, std::string_view value,
                                  std::string_view remedy);

std::string to_text(double value);

template <class Value>
  requires std::integral<Value> || std::floating_point<Value>
void require(bool ok, std::string_view field, Value value, std::string_view remedy) {
  if (ok) return;
  if constexpr (std::integral<Value>) {
    throw_bad_value(field, std::to_string(value), remedy);
  } else {
    throw_bad_value(field, to_text(value), remedy);
  }
}

// Throws BadValue for a value beyond `last`: C++ lets any number be cast to an
// enumeration. Its values run from 0.
template <class Enumeration>
void require_known(Enumeration value, Enumeration last, std::string_view field) {
  const auto number = static_cast<std::int64_t>(value);
  require(number >= 0 && number <= static_cast<std::int64_t>(last), field, number,
          "must be one of the named values");
}

enum class TimeUnit { us, ms };

// Throws BadValue, in the unit that Python's name of the field carries.
void require_time(bool ok, std::string_view field, std::chrono::nanoseconds value, TimeUnit unit,
                  std::string_view remedy);

// Returns a latency bound in ns. Throws BadValue for one out of range.
std::int64_t checked_latency_ns(std::chrono::nanoseconds latency);

namespace detail {

// Throws NoMemory("<field> = <value>: needs ... of memory, which cannot be had; choose less").
[[noreturn]] void throw_no_memory(std::string_view field, std::size_t value, double bytes);

// So many values, allocated once, as the field with this value asks for. The memory is not
// initialised, so its pages cost nothing until they are used.
template <class Value>
std::unique_ptr<Value[]> allocate(std::size_t count, std::string_view field, std::size_t value) {
  constexpr std::size_t kMax = std::numeric_limits<std::ptrdiff_t>::max() / sizeof(Value);
  Value* const memory = count <= kMax ? new (std::nothrow) Value[count] : nullptr;
  if (memory == nullptr) {
    throw_no_memory(field, value, static_cast<double>(count) * sizeof(Value));
  }
  return std::unique_ptr<Value[]>(memory);
}

}  // namespace detail

}  // namespace asap::inline v0_1
