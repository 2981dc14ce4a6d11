// Argument checks of the constructors that take a configuration. An error names the field, the
// value and the remedy. The throw is out of line, so headers compile with -fno-exceptions too.
#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace asap {

// Throws std::invalid_argument("<field> = <value>: <remedy>").
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

}  // namespace asap
