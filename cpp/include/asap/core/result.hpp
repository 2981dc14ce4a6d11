// Result: an object, or the message that says why there is none. make_pipeline(), make_simulator(),
// make_tracker() and make_scheme() return it, for programs that are compiled with -fno-exceptions:
//
//   auto pipeline = asap::make_pipeline({.latency = 10ms}, algorithm);
//   if (!pipeline) return fail(pipeline.message());   // "latency = -5 ms: must be between ..."
//   pipeline->push(events);
//
// Any thread. The object lies on the heap and keeps its address when the result is moved.
#pragma once

#include <memory>
#include <string>
#include <utility>

namespace asap {

template <class Value>
class [[nodiscard]] Result {
 public:
  // Neither: a member that is assigned later.
  Result() noexcept = default;
  explicit Result(std::unique_ptr<Value> value) noexcept : value_(std::move(value)) {}
  explicit Result(std::string message) noexcept : message_(std::move(message)) {}

  explicit operator bool() const noexcept { return value_ != nullptr; }

  // Precondition: there is an object.
  Value& operator*() const noexcept { return *value_; }
  Value* operator->() const noexcept { return value_.get(); }

  // The object, which the result has no longer; null if there is none.
  std::unique_ptr<Value> release() noexcept { return std::move(value_); }

  // "<field> = <value>: <remedy>"; empty if there is an object.
  const std::string& message() const noexcept { return message_; }

 private:
  std::unique_ptr<Value> value_;
  std::string message_;
};

}  // namespace asap
