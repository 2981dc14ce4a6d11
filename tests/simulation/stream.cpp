#include "stream.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace asap::simulation {
namespace {

constexpr std::int64_t kLimit = std::int64_t{3} << 50;  // of a stamp, us

// What a rate fault makes of the mean gap.
double rate_factor(const Fault& fault, std::size_t number) {
  Draw draw = fault.draw();
  const std::size_t shape = draw.below(4);
  const double factor = draw.octaves(2, 100);
  const std::size_t half_period = 1 + draw.below(500);
  if (shape == 0) return 1 / factor;
  if (shape == 1) return factor;
  if (shape == 2) return (number - fault.begin) / half_period % 2 == 0 ? 1 / factor : factor / 4;
  const double share =
      static_cast<double>(number - fault.begin) / static_cast<double>(fault.end - fault.begin);
  return 1 / (1 + (factor - 1) * share);
}

double silence_ns(const Fault& fault, std::size_t number, std::int64_t latency_ns) {
  Draw draw = fault.draw();
  if (number != fault.begin) return 0;
  return draw.chance(0.3) ? 1e10 : static_cast<double>(latency_ns) * draw.octaves(0.5, 32);
}

bool is_burst(const Fault& fault, std::size_t number) {
  Draw draw = fault.draw();
  draw.bits();
  const auto longest = static_cast<std::size_t>(draw.octaves(1, 4096));
  return number > fault.begin && number < std::min(fault.end, fault.begin + longest);
}

}  // namespace

Stream::Stream(const Setup& setup, const std::vector<Fault>& faults)
    : setup_(setup), faults_(faults), random_(setup.seed ^ 5), draw_(setup.seed, 6) {}

double Stream::gap_ns(std::size_t number) const noexcept {
  double gap = setup_.gap_ns * 2 * random_.uniform(number);
  for (const Fault& fault : faults_) {
    if (!fault.acts(number)) continue;
    if (fault.kind == FaultKind::rate) gap *= rate_factor(fault, number);
    if (fault.kind != FaultKind::silence) continue;
    if (is_burst(fault, number)) gap = 0;
    gap += silence_ns(fault, number, setup_.latency_ns);
  }
  return gap;
}

void Stream::read(Packet& packet) {
  packet.events.clear();
  packet.numbers.clear();
  std::size_t size = 1 + random_(~next_) % setup_.longest_packet;
  for (const Fault& fault : faults_) {
    if (fault.kind != FaultKind::anomalies || !fault.acts(next_)) continue;
    if (draw_.chance(0.05)) size *= 20;
    if (draw_.chance(0.05)) size = 0;
  }
  const int width = setup_.door.width == 0 ? 65536 : setup_.door.width;
  const int height = setup_.door.height == 0 ? 65536 : setup_.door.height;
  for (; size > 0 && !ended(); --size, ++next_) {
    time_ns_ += static_cast<std::int64_t>(gap_ns(next_));
    const auto number = static_cast<std::int64_t>(next_);
    Event event{.x = static_cast<std::uint16_t>(number % width),
                .y = static_cast<std::uint16_t>(number / width % height),
                .p = static_cast<std::int16_t>(number & 1),
                .t = setup_.base_us + shift_us_ + time_ns_ / 1000};
    for (const Fault& fault : faults_) {
      if (fault.kind == FaultKind::anomalies && fault.acts(next_)) spoil(fault, event, packet);
    }
    packet.events.push_back(event);
    packet.numbers.push_back(static_cast<std::uint32_t>(next_));
    if (event.t > -kLimit && event.t < kLimit) last_us_ = event.t;
  }
  packet.sent_ns = time_ns_;
}

void Stream::spoil(const Fault& fault, Event& event, Packet& packet) {
  if (stuck_ > 0) {
    --stuck_;
    event.t = stuck_us_;
  }
  Draw details = fault.draw();
  if (!draw_.chance(details.octaves(1e-6, 1))) return;
  std::uint64_t kinds = details.bits();  // a draw for each statement: | has no order
  kinds |= std::uint64_t{1} << details.below(9);
  const std::size_t kind = draw_.below(9);
  if ((kinds >> kind & 1U) == 0) return;
  constexpr std::array<std::int64_t, 6> kNoTimes{kLimit + 1,
                                                 -kLimit - 1,
                                                 kLimit,
                                                 -kLimit,
                                                 std::numeric_limits<std::int64_t>::min(),
                                                 std::numeric_limits<std::int64_t>::max()};
  constexpr std::array<std::int16_t, 5> kNoPolarities{-1, 2, 3, -32768, 32767};
  switch (kind) {
    case 0:  // back a little, or to where the door's rules change
      if (draw_.chance(0.5)) {
        event.t -= draw_.between(1, draw_.chance(0.5) ? 100 : 1'100'000);
      } else {
        const std::int64_t tolerance_us =
            setup_.door.reorder_tolerance / std::chrono::microseconds(1);
        const std::array<std::int64_t, 5> steps{1, tolerance_us, tolerance_us + 1, 999'999,
                                                1'000'000};
        event.t = last_us_ - steps[draw_.below(steps.size())];
      }
      break;
    case 1:  // the sensor's clock is reset
      shift_us_ -= draw_.between(0, 3'000'000);
      break;
    case 2:  // outside the sensor
      event.x = static_cast<std::uint16_t>(draw_.bits());
      event.y = static_cast<std::uint16_t>(draw_.bits());
      break;
    case 3:  // time is stuck
      stuck_ = draw_.below(600);
      stuck_us_ = event.t;
      break;
    case 4:  // twice
      packet.events.push_back(event);
      packet.numbers.push_back(static_cast<std::uint32_t>(next_));
      break;
    case 5:
      event.p = kNoPolarities[draw_.below(kNoPolarities.size())];
      break;
    case 6:
      event.t = kNoTimes[draw_.below(kNoTimes.size())];
      break;
    case 7:  // far ahead, once
      event.t += static_cast<std::int64_t>(draw_.octaves(1, 1e12));
      break;
    default:  // ahead, for good
      shift_us_ += draw_.between(1, 2'000'000);
  }
}

}  // namespace asap::simulation
