// BadValue and NoMemory: what a constructor throws. Result: an object, or the error that says why
// there is none. make_pipeline(), make_simulator(), make_tracker() and make_scheme() return it, for
// programs that are compiled with -fno-exceptions:
//
//   auto pipeline = asap::make_pipeline({.latency = 10ms}, algorithm);
//   if (!pipeline) return fail(pipeline.message());   // "latency = -5 ms: must be between ..."
//   pipeline->push(events);
//
// Any thread. The object lies on the heap and keeps its address when the result is moved.
#pragma once

#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace asap::inline v0_1 {

// A value that a field must not have. what() says "<field> = <value> <unit>: <remedy>".
struct BadValue : std::invalid_argument {
  BadValue(std::string_view field, std::string_view value, std::string_view unit,
           std::string_view remedy);

  std::string field;
  std::string value;
  std::string unit;  // "us" or "ms" of a time, otherwise empty
  std::string remedy;
};

// Memory of a size that the user has chosen, which cannot be had. MemoryError in Python.
class NoMemory : public std::bad_alloc {
 public:
  explicit NoMemory(const std::string& message) : message_(message) {}
  const char* what() const noexcept override { return message_.what(); }

 private:
  std::runtime_error message_;  // a string whose copy does not throw
};

// Why there is no object. Field, value and remedy are empty where no field is to blame, such as for
// a thread that the system refused.
struct Error {
  std::string message{};  // "<field> = <value>: <remedy>"
  std::string field{};
  std::string value{};  // a time with its unit
  std::string remedy{};
};

template <class Value>
class [[nodiscard]] Result {
 public:
  // No object and no error: a member that is assigned later.
  Result() noexcept = default;
  explicit Result(std::unique_ptr<Value> value) noexcept : value_(std::move(value)) {}
  explicit Result(Error error) noexcept : error_(std::move(error)) {}

  explicit operator bool() const noexcept { return value_ != nullptr; }

  // Precondition: there is an object.
  Value& operator*() const noexcept { return *value_; }
  Value* operator->() const noexcept { return value_.get(); }

  // Hands the object over; null if there is none.
  std::unique_ptr<Value> release() noexcept { return std::move(value_); }

  // All parts are empty if there is an object.
  const Error& error() const noexcept { return error_; }
  const std::string& message() const noexcept { return error_.message; }

 private:
  std::unique_ptr<Value> value_;
  Error error_;
};

}  // namespace asap::inline v0_1
