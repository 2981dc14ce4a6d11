// Bytes: turns the fuzzer's input into values, front to back; past the end everything is zero, so
// that every input is a whole test case. Numbers of a configuration are mostly within their range,
// often on its edges, sometimes nothing a configuration can hold.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::fuzz {

// Ends the process, so that the fuzzer keeps the input.
inline void check(bool ok) {
  if (!ok) __builtin_trap();
}

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : left_(data, size) {}

  bool empty() const { return left_.empty(); }
  std::span<const std::uint8_t> rest() const { return left_; }

  template <class Value>
  Value take() {
    Value value{};
    const std::size_t size = std::min(sizeof(Value), left_.size());
    std::memcpy(&value, left_.data(), size);
    left_ = left_.subspan(size);
    return value;
  }

  bool flag() { return (take<std::uint8_t>() & 1) != 0; }
  std::size_t below(std::size_t limit) { return take<std::uint16_t>() % limit; }

  std::size_t count(std::size_t high) {
    const auto kind = take<std::uint8_t>();
    if (kind < 8) return static_cast<std::size_t>(take<std::uint64_t>());
    if (kind < 48) return std::array{std::size_t{0}, std::size_t{1}, high, high + 1}[kind % 4];
    return take<std::uint32_t>() % (kind % 2 == 0 ? high : std::size_t{2000});
  }

  // Events of 16 bytes each, whatever they hold. The padding has no value and stays zero.
  std::vector<Event> events(std::size_t max) {
    std::vector<Event> events;
    while (!left_.empty() && events.size() < max) {
      const auto x = take<std::uint16_t>(), y = take<std::uint16_t>();
      const auto p = take<std::int16_t>();
      take<std::uint16_t>();
      events.push_back({x, y, p, take<std::int64_t>()});
    }
    return events;
  }

  // Events by small steps of time, now and then a wild one: what a camera with faults sends.
  std::vector<Event> stream(std::size_t max) {
    std::vector<Event> events;
    auto t = static_cast<std::uint64_t>(take<std::int32_t>());  // wraps
    while (!left_.empty() && events.size() < max) {
      const auto step = take<std::uint8_t>();
      if (step >= 240) {
        t = step >= 252 ? take<std::uint64_t>()
                        : t + static_cast<std::uint64_t>(take<std::int32_t>());
      } else {
        t += step < 128 ? step : std::uint64_t{step} * step;
      }
      const auto place = take<std::uint16_t>();
      events.push_back({static_cast<std::uint16_t>(place % 350),
                        static_cast<std::uint16_t>(place / 350),
                        static_cast<std::int16_t>(place % 64 == 0 ? place % 5 - 2 : place & 1),
                        static_cast<std::int64_t>(t)});
    }
    return events;
  }

 private:
  std::span<const std::uint8_t> left_;
};

}  // namespace asap::fuzz
