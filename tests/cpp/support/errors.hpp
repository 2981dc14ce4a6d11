// What a constructor says about a bad configuration.
#pragma once

#include <stdexcept>
#include <string>

namespace asap::test {

template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace asap::test
