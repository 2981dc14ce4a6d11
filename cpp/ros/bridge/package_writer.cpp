#include "ros/bridge/package_writer.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <string>

#include "asap/core/result.hpp"

namespace asap::ros {
namespace {

constexpr std::int64_t kNsPerUs = 1000;
constexpr std::int64_t kMonoRange_us = std::numeric_limits<std::uint32_t>::max() / kNsPerUs;
constexpr std::int64_t kEvt3Range_us = std::int64_t{1} << 24;  // its readers see stamps modulo that
constexpr std::int64_t kMostGap_us = std::int64_t{1} << 36;    // 19 h: 64 kB of marks
constexpr std::size_t kBlock = 256;                            // events

}  // namespace

PackageWriter::PackageWriter(std::string_view encoding) : is_mono_(encoding == "mono") {
  if (!is_mono_ && encoding != "evt3") throw BadValue("encoding", encoding, {}, "mono or evt3");
}

PackageWriter::Written PackageWriter::write(EventSpan events, std::vector<std::uint8_t>& bytes,
                                            std::span<const Trigger> triggers) {
  bytes.clear();
  if (is_mono_) return write_mono(events, bytes);
  write_evt3(events, triggers, bytes);
  return {.events = events.size()};
}

PackageWriter::Written PackageWriter::write_mono(EventSpan events,
                                                 std::vector<std::uint8_t>& bytes) const {
  const std::int64_t base_us = events.front().t;
  const auto reaches = [&](const Event& event) { return event.t - base_us <= kMonoRange_us; };
  const auto end =
      reaches(events.back()) ? events.end() : std::ranges::partition_point(events, reaches);
  const auto count = static_cast<std::size_t>(end - events.begin());
  bytes.resize(count * sizeof(std::uint64_t));
  std::uint8_t* to = bytes.data();
  for (const Event& event : events.first(count)) {
    std::uint64_t word = static_cast<std::uint64_t>((event.t - base_us) * kNsPerUs) |
                         std::uint64_t{event.x} << 32 | std::uint64_t{event.y} << 48 |
                         static_cast<std::uint64_t>(event.p > 0) << 63;
    for (std::size_t i = 0; i < sizeof word; ++i, word >>= 8) {
      *to++ = static_cast<std::uint8_t>(word & 0xff);
    }
  }
  return {.events = count, .time_base = static_cast<std::uint64_t>(base_us * kNsPerUs)};
}

// The encoder bridges gaps by marks and refuses a stamp that goes back: it begins with the range of
// EVT3 in which the stamp lies, as a reader does, and begins anew where the stamps do.
void PackageWriter::write_evt3(EventSpan events, std::span<const Trigger> triggers,
                               std::vector<std::uint8_t>& bytes) {
  std::array<std::byte, kBlock * Encoder::kMaxPerEvent> encoded;
  bytes.reserve(events.size() * 4 + Encoder::kMaxPerEvent);
  evt3_.restate();
  while (!events.empty()) {
    if (events.front().t < last_us_ || events.front().t - last_us_ > kMostGap_us) {
      last_us_ = events.front().t;
      if (!triggers.empty()) {
        last_us_ = std::clamp(triggers.front().t, last_us_ - kEvt3Range_us, last_us_);
      }
      evt3_.reset(last_us_ & ~(kEvt3Range_us - 1));
    }
    for (; !triggers.empty() && triggers.front().t <= events.front().t;
         triggers = triggers.subspan(1)) {
      write_evt3(triggers.front(), bytes);
    }
    std::size_t count = std::min(kBlock, events.size());
    while (!triggers.empty() && events[count - 1].t >= triggers.front().t) --count;
    while (events[count - 1].t - last_us_ > kMostGap_us) --count;  // the first one goes on
    last_us_ = events[count - 1].t;
    EventSpan block = events.first(count);
    events = events.subspan(count);
    while (!block.empty()) {
      const Progress done = evt3_.encode(block, encoded);
      const auto* const first = reinterpret_cast<const std::uint8_t*>(encoded.data());
      bytes.insert(bytes.end(), first, first + done.bytes);
      block = block.subspan(done.events);
    }
  }
  for (const Trigger& trigger : triggers) write_evt3(trigger, bytes);
}

void PackageWriter::write_evt3(Trigger trigger, std::vector<std::uint8_t>& bytes) {
  std::array<std::byte, 2 * Encoder::kMaxPerEvent> encoded;
  last_us_ = std::max(trigger.t, last_us_);  // a clock that was set back
  trigger.t = last_us_;
  for (Progress done; done.triggers == 0;) {
    done = evt3_.encode(trigger, encoded);
    const auto* const first = reinterpret_cast<const std::uint8_t*>(encoded.data());
    bytes.insert(bytes.end(), first, first + done.bytes);
  }
}

}  // namespace asap::ros
