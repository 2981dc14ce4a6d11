// made<T>(make): what make() constructs, for a caller without exceptions; whatever it throws
// becomes the error of the result. For compiled sources only: no header of the user holds a try.
// Any thread.
#pragma once

#include <exception>
#include <new>
#include <utility>

#include "asap/core/result.hpp"

namespace asap::inline v0_1 {

// Copies. Where there is no memory for them: "no memory left", which needs none.
Error error_of(const BadValue& bad) noexcept;
Error error_of(const char* message) noexcept;

template <class Value, class Make>
Result<Value> made(Make&& make) noexcept {
  try {
    return Result<Value>(std::forward<Make>(make)());
  } catch (const BadValue& bad) {
    return Result<Value>(error_of(bad));
  } catch (const NoMemory& error) {
    return Result<Value>(error_of(error.what()));
  } catch (const std::bad_alloc&) {
    return Result<Value>(error_of("no memory left"));
  } catch (const std::exception& error) {
    return Result<Value>(error_of(error.what()));
  } catch (...) {
    return Result<Value>(error_of("an exception that is no std::exception"));
  }
}

}  // namespace asap::inline v0_1
