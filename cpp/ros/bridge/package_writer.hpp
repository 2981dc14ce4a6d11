// PackageWriter: the events of a package as bytes of event_camera_msgs, in "mono" or "evt3". Every
// message can be read without the ones before it: EVT3 states time and row at its beginning.
//
// One thread. O(events). Allocates the bytes, which go into the message without a copy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/formats/encoder.hpp"

namespace asap::ros {

class PackageWriter {
 public:
  struct Written {
    std::size_t events = 0;       // from the front, as many as one message can hold
    std::uint64_t time_base = 0;  // ns
  };

  // "mono" or "evt3"; throws std::invalid_argument for another one.
  explicit PackageWriter(std::string_view encoding);

  // Writes the first message of `events`, which are not empty and in time order and whose
  // coordinates are below kMostPixels. `bytes` are replaced. In "evt3", `triggers` stand between
  // the events, in order of time; their ids are below 16.
  Written write(EventSpan events, std::vector<std::uint8_t>& bytes,
                std::span<const Trigger> triggers = {});

 private:
  Written write_mono(EventSpan events, std::vector<std::uint8_t>& bytes) const;
  void write_evt3(EventSpan events, std::span<const Trigger> triggers,
                  std::vector<std::uint8_t>& bytes);
  void write_evt3(Trigger trigger, std::vector<std::uint8_t>& bytes);

  const bool is_mono_;
  Encoder evt3_{{.encoding = Encoding::evt3}};
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace asap::ros
