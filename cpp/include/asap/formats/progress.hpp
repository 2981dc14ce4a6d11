// What all native decoders share: how far a call came, the triggers it met, the records that are
// none, and the bytes of a record that was cut.
//
// One thread. O(1), no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace asap {

// What one call of decode() consumed and wrote.
struct Progress {
  std::size_t bytes = 0;
  std::size_t events = 0;
  std::size_t triggers = 0;  // into the third span; 0 without it

  friend bool operator==(const Progress&, const Progress&) = default;
};

// An edge at an external input of the camera. 16 bytes.
struct Trigger {
  std::int64_t t;       // us of the sensor's clock
  std::uint16_t id;     // of the input
  std::uint16_t value;  // 1 = rising, 0 = falling edge

  friend bool operator==(const Trigger&, const Trigger&) = default;
};

// Records that are none: how many, and the byte offsets of the first.
class BadRecords {
 public:
  static constexpr std::size_t kNoted = 16;

  void add(std::uint64_t offset) noexcept {
    if (count_ < kNoted) noted_[static_cast<std::size_t>(count_)] = offset;
    ++count_;
  }

  std::uint64_t count() const noexcept { return count_; }

  std::span<const std::uint64_t> noted() const noexcept {
    return {noted_.data(), static_cast<std::size_t>(std::min<std::uint64_t>(count_, kNoted))};
  }

 private:
  std::array<std::uint64_t, kNoted> noted_{};
  std::uint64_t count_ = 0;
};

// The first bytes of a record of kSize bytes whose end is yet to come.
template <std::size_t kSize>
struct CutRecord {
  std::array<std::byte, kSize> bytes{};
  std::size_t size = 0;  // < kSize between two calls
};

}  // namespace asap
