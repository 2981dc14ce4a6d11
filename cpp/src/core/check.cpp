#include "asap/core/check.hpp"

#include <cstdio>
#include <stdexcept>

namespace asap {

void throw_bad_value(std::string_view field, std::string_view value, std::string_view remedy) {
  std::string message;
  message.append(field).append(" = ").append(value).append(": ").append(remedy);
  throw std::invalid_argument(message);
}

std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

}  // namespace asap
