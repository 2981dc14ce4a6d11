// made<T>(make): what make() constructs, for a caller without exceptions; whatever it throws
// becomes the message of the result. For compiled sources only: no header of the user holds a try.
// Any thread.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "asap/core/check.hpp"
#include "asap/core/result.hpp"

namespace asap {

// A copy of the text. Where there is no memory for it: "no memory left", which needs none.
std::string message_of(const char* text) noexcept;

template <class Value, class Make>
Result<Value> made(Make&& make) noexcept {
  try {
    return Result<Value>(std::forward<Make>(make)());
  } catch (const NoMemory& error) {
    return Result<Value>(message_of(error.what()));
  } catch (const std::bad_alloc&) {
    return Result<Value>(message_of("no memory left"));
  } catch (const std::exception& error) {
    return Result<Value>(message_of(error.what()));
  } catch (...) {
    return Result<Value>(message_of("an exception that is no std::exception"));
  }
}

}  // namespace asap
