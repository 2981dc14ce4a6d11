#include "asap/filter/validator.hpp"

#include <bit>
#include <cstring>
#include <string>

#include "core/bit_log.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

namespace {

using namespace std::chrono_literals;
constexpr int kAddresses = 65536;  // x and y are 16 bits wide

std::uint32_t largest_address(int size) noexcept {
  return static_cast<std::uint32_t>(size == 0 ? kAddresses : size) - 1;
}

bool is_polarity(std::int16_t p) noexcept { return static_cast<std::uint16_t>(p) <= 1; }

bool is_stamp(std::int64_t t) noexcept {
  return t >= -Validator::kMaxRawStamp_us && t <= Validator::kMaxRawStamp_us;
}

// x, y and p of an event as three lanes of 16 bits, x lowest; the fourth lane has no meaning.
std::uint64_t lanes(const Event& event) noexcept {
  std::uint64_t word = 0;
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(&word, &event, sizeof word);  // one load
  } else {
    word = std::uint64_t{event.x} | std::uint64_t{event.y} << 16 |
           std::uint64_t{static_cast<std::uint16_t>(event.p)} << 32;
  }
  return word;
}

// Added to such a word, this carries out of the lane of each field that is above its limit. A carry
// changes the lane above it only where the event is bad anyway.
std::uint64_t room_above(std::uint64_t max_x, std::uint64_t max_y) noexcept {
  constexpr std::uint64_t kLane = 0xffff;
  return (kLane - max_x) | (kLane - max_y) << 16 | (kLane - 1) << 32;
}
constexpr std::uint64_t kCarries = 1ULL << 16 | 1ULL << 32 | 1ULL << 48;

// From one timestamp to the next. Between timestamps in order it is below kSteps_us, a power of
// two; backwards, or to a timestamp far out of range, it is not.
std::uint64_t step_us(std::int64_t from, std::int64_t to) noexcept {
  return static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from);
}
constexpr std::uint64_t kSteps_us = 2ULL * Validator::kMaxStamp_us;
static_assert(std::has_single_bit(kSteps_us));

}  // namespace

Validator::Validator(ValidatorConfig config)
    : config_(config),
      reorder_tolerance_us_(config.reorder_tolerance / 1us),
      warmup_discard_us_(config.warmup_discard / 1us),
      max_x_(largest_address(config.width)),
      max_y_(largest_address(config.height)),
      warming_up_(warmup_discard_us_ > 0) {
  require(config.width >= 0 && config.width <= kAddresses, "width", config.width,
          "give the sensor's width in pixels, at most 65536, or 0 for no check");
  require(config.height >= 0 && config.height <= kAddresses, "height", config.height,
          "give the sensor's height in pixels, at most 65536, or 0 for no check");
  require_known(config.on_bad, OnBad::raise, "on_bad");
  require_time(config.reorder_tolerance >= 0us && config.reorder_tolerance < 1s,
               "reorder_tolerance", config.reorder_tolerance, TimeUnit::us,
               "give 0 to 999999 us; a timestamp that goes back by 1 s starts a new epoch");
  require_time(config.warmup_discard >= 0us && config.warmup_discard <= 1000s, "warmup_discard",
               config.warmup_discard, TimeUnit::us, "give 0 to 1e9 us");
}

bool Validator::pass_clean(EventSpan block) {
  if (warming_up_) return false;
  // Additions and bits alone, without a branch per event, so that the compiler can treat two events
  // at once. Stamps that do not decrease and end below the limit are all below it; the lower limit
  // is where last_us_ starts.
  const std::uint64_t room = room_above(max_x_, max_y_);
  const auto carry = [room](const Event& event) {
    const std::uint64_t pixel = lanes(event);
    return (pixel + room) ^ pixel ^ room;
  };
  std::uint64_t carries = carry(block.front());
  std::uint64_t steps = step_us(last_us_ - clock_offset_us_, block.front().t);
  for (std::size_t i = 1; i < block.size(); ++i) {
    carries |= carry(block[i]);
    steps |= step_us(block[i - 1].t, block[i].t);
  }
  const std::int64_t last = block.back().t;
  if ((carries & kCarries) != 0 || steps >= kSteps_us || last > kMaxRawStamp_us) return false;
  const std::int64_t shifted_us = last + clock_offset_us_;
  if (shifted_us > kMaxStamp_us) return false;
  last_us_ = shifted_us;
  far_back_ = 0;
  received_ += block.size();
  if (passed_ != nullptr) passed_->append(block.size(), true);
  return true;
}

EventSpan Validator::shifted(EventSpan block) noexcept {
  const std::int64_t offset_us = clock_offset_us_;
  for (std::size_t i = 0; i < block.size(); ++i) {
    Event event = block[i];
    event.t += offset_us;
    scratch_[i] = event;
  }
  return {scratch_.data(), block.size()};
}

void Validator::begin_epoch(std::int64_t first_us) noexcept {
  if (last_us_ == kNone_us || !is_stamp(first_us)) return;
  clock_offset_us_ = last_us_ + 1 - first_us;
  far_back_ = 0;
  ++clock_resets_;
}

// `rest` begins with the block: what comes next decides about a timestamp that is far back.
Validator::Repaired Validator::repair(EventSpan block, EventSpan rest) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < block.size(); ++i) {
    ++received_;
    Event event = block[i];
    const Fault fault = warms_up(event) ? Fault::before_start : mend(event, rest.subspan(i));
    if (passed_ != nullptr) passed_->append(fault == Fault::none);
    if (fault == Fault::none) {
      last_us_ = event.t;
      scratch_[kept++] = event;
      continue;
    }
    count(fault);
    if (config_.on_bad == OnBad::raise && fault != Fault::before_start)
      return {.kept = kept, .read = i, .fault = fault};
  }
  return {.kept = kept, .read = block.size()};
}

// Before anything else: the rest of an earlier run need not make sense.
bool Validator::warms_up(const Event& event) noexcept {
  if (!warming_up_) return false;
  if (!is_stamp(event.t)) return true;
  if (event.t <= warm_up_last_us_ - kNewEpoch_us) warm_up_first_us_ = event.t;
  warm_up_last_us_ = event.t;
  warming_up_ = event.t - warm_up_first_us_ < warmup_discard_us_;
  return warming_up_;
}

// Whether the timestamps from the first of `rest` on, which is far back, stay where it is. Without
// enough of them: only with those that came before.
bool Validator::stays(EventSpan rest) noexcept {
  if (!doubts_resets_) return true;
  std::size_t seen = 0;
  for (; seen < rest.size() && far_back_ + seen < kStays; ++seen) {
    if (!is_stamp(rest[seen].t)) continue;
    if (last_us_ - (rest[seen].t + clock_offset_us_) < kNewEpoch_us) return false;
  }
  return far_back_ + seen >= kStays;
}

Validator::Fault Validator::mend(Event& event, EventSpan rest) noexcept {
  if (!is_stamp(event.t)) return Fault::bad_record;
  const bool inside = event.x <= max_x_ && event.y <= max_y_;
  if (!inside && config_.on_bad != OnBad::clamp) return Fault::out_of_bounds;

  std::int64_t t = event.t + clock_offset_us_;
  const std::int64_t back = last_us_ - t;
  const bool new_epoch = back >= kNewEpoch_us;
  const bool lifted = back > 0 && !new_epoch;
  if (lifted && back > reorder_tolerance_us_ && config_.on_bad != OnBad::clamp) {
    return Fault::nonmonotonic;
  }
  if (new_epoch && !stays(rest)) {
    ++far_back_;
    return Fault::nonmonotonic;
  }
  far_back_ = 0;
  if (new_epoch) t = last_us_ + 1;
  if (lifted) t = last_us_;
  if (t > kMaxStamp_us) return Fault::bad_record;

  if (new_epoch) {
    clock_offset_us_ = t - event.t;
    ++clock_resets_;
  }
  event.t = t;
  repairs_.lifted_stamps += lifted;
  if (!inside) {
    event.x = static_cast<std::uint16_t>(std::min<std::uint32_t>(event.x, max_x_));
    event.y = static_cast<std::uint16_t>(std::min<std::uint32_t>(event.y, max_y_));
    ++repairs_.clamped_positions;
  }
  repairs_.normalised_polarity += !is_polarity(event.p);
  event.p = event.p > 0;
  return Fault::none;
}

void Validator::count(Fault fault) noexcept {
  rejected_.bad_record += fault == Fault::bad_record;
  rejected_.out_of_bounds += fault == Fault::out_of_bounds;
  rejected_.nonmonotonic += fault == Fault::nonmonotonic;
  rejected_.before_start += fault == Fault::before_start;
}

void Validator::refuse(const Event& event, Fault fault) const {
  const std::string number = " (event " + std::to_string(received_ - 1) + ")";
  const auto value = [&](auto field) { return std::to_string(field) + number; };
  if (fault == Fault::bad_record) {
    throw_bad_value("t", value(event.t),
                    "not a time in us; check the time unit, or drop with on_bad = drop");
  }
  if (fault == Fault::out_of_bounds && event.x > max_x_) {
    throw_bad_value("x", value(event.x),
                    "outside the sensor, width = " + std::to_string(config_.width) +
                        "; check the width, or drop with on_bad = drop");
  }
  if (fault == Fault::out_of_bounds) {
    throw_bad_value("y", value(event.y),
                    "outside the sensor, height = " + std::to_string(config_.height) +
                        "; check the height, or drop with on_bad = drop");
  }
  throw_bad_value("t", value(event.t),
                  "goes back behind " + std::to_string(last_us_ - clock_offset_us_) +
                      "; sort the events, raise the reorder tolerance, or drop with on_bad = drop");
}

}  // namespace asap::inline v0_1
