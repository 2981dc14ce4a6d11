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

void throw_no_memory(std::string_view field, std::size_t value, double bytes) {
  constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;
  char size[32];
  std::snprintf(size, sizeof size, "%.3g GiB", bytes / kGibibyte);
  std::string message;
  message.append(field).append(" = ").append(std::to_string(value));
  message.append(": needs ").append(size);
  message.append(" of memory, which cannot be had; choose less");
  throw NoMemory(message);
}

}  // namespace asap
