// Atis40Decoder: events of 40 bits, as N-MNIST and N-Caltech101 (.bin) and DvsGesture cuts (.bs2)
// hold them.
//
// Layout: no header. A record has 5 bytes, big-endian: x 8 bits, y 8, polarity 1, time in us 23. A
// record with y = 240, one row below the sensor, is no event: it adds 2^13 us to all times that
// follow. Source: the readers of the N-MNIST data set (Orchard et al. 2015). Nothing in these bytes
// tells the format: only the name of the file or the user does. Every record has a meaning: there
// are no bad records and no triggers.
// One thread. O(bytes), no allocation, never throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Atis40Config {
  bool marks = true;  // whether y = 240 marks 2^13 us; false: it is a row like any other
};

class Atis40Decoder : public NativeDecoder<Atis40Decoder, Atis40Config, 5> {
 public:
  static constexpr std::size_t kMostPerRecord = 1;

  explicit Atis40Decoder(const Atis40Config& config = {}) noexcept : NativeDecoder(config) {}

 private:
  friend NativeDecoder;

  std::size_t decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept;

  std::int64_t marked_us_ = 0;
};

}  // namespace asap
