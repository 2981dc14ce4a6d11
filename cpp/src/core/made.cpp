#include "core/made.hpp"

namespace asap::inline v0_1 {
namespace {

template <class Copy>
Error copied(const Copy& copy) noexcept {
  try {
    return copy();
  } catch (...) {
    return {.message = "no memory left"};  // short: a string holds it without allocation
  }
}

}  // namespace

Error error_of(const BadValue& bad) noexcept {
  return copied([&] {
    return Error{.message = bad.what(),
                 .field = bad.field,
                 .value = bad.unit.empty() ? bad.value : bad.value + ' ' + bad.unit,
                 .remedy = bad.remedy};
  });
}

Error error_of(const char* message) noexcept {
  return copied([&] { return Error{.message = message}; });
}

}  // namespace asap::inline v0_1
