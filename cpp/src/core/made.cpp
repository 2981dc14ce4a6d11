#include "core/made.hpp"

namespace asap {

std::string message_of(const char* text) noexcept {
  try {
    return text;
  } catch (...) {
    return "no memory left";  // short: a string holds it without allocation
  }
}

}  // namespace asap
