#include "asap/core/allocate.hpp"

#include <cstdio>

namespace asap {

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
