#include "asap/filter/validator.hpp"

#include <string>

#include "asap/core/check.hpp"
#include "core/bit_log.hpp"

namespace asap {

namespace {

constexpr std::int64_t kLongestWarmUp_us = 1'000'000'000;
constexpr int kAddresses = 65536;  // x and y are 16 bits wide

std::uint32_t largest_address(int size) noexcept {
  return static_cast<std::uint32_t>(size == 0 ? kAddresses : size) - 1;
}

bool is_polarity(std::int16_t p) noexcept { return static_cast<std::uint16_t>(p) <= 1; }

bool is_stamp(std::int64_t t) noexcept {
  return t >= -Validator::kMaxRawStamp_us && t <= Validator::kMaxRawStamp_us;
}

}  // namespace

Validator::Validator(ValidatorConfig config, BitLog* passed)
    : config_(config),
      passed_(passed),
      max_x_(largest_address(config.width)),
      max_y_(largest_address(config.height)),
      warming_up_(config.warmup_discard_us > 0) {
  require(config.width >= 0 && config.width <= kAddresses, "width", config.width,
          "give the sensor's width in pixels, at most 65536, or 0 for no check");
  require(config.height >= 0 && config.height <= kAddresses, "height", config.height,
          "give the sensor's height in pixels, at most 65536, or 0 for no check");
  require_known(config.on_bad, OnBad::raise, "on_bad");
  require(config.reorder_tolerance_us >= 0 && config.reorder_tolerance_us < kNewEpoch_us,
          "reorder_tolerance_us", config.reorder_tolerance_us,
          "give 0 to 999999 us; a stamp that goes back by 1 s starts a new epoch");
  require(config.warmup_discard_us >= 0 && config.warmup_discard_us <= kLongestWarmUp_us,
          "warmup_discard_us", config.warmup_discard_us, "give 0 to 1e9 us");
}

bool Validator::pass_clean(EventSpan block) {
  if (clock_offset_us_ != 0 || warming_up_) return false;
  // One flag for the whole block: no branch per event. Stamps that do not decrease and end below
  // the limit are all below it; the lower limit is where last_us_ starts.
  std::int64_t last = last_us_;
  bool bad = false;
  for (const Event& event : block) {
    bad |= (event.x > max_x_) | (event.y > max_y_) | !is_polarity(event.p) | (event.t < last);
    last = event.t;
  }
  if (bad || last > kMaxRawStamp_us) return false;
  last_us_ = last;
  received_ += block.size();
  if (passed_ != nullptr) passed_->append(block.size(), true);
  return true;
}

Validator::Repaired Validator::repair(EventSpan block) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < block.size(); ++i) {
    ++received_;
    Event event = block[i];
    const Fault fault = warms_up(event) ? Fault::before_start : mend(event);
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
  warming_up_ = event.t - warm_up_first_us_ < config_.warmup_discard_us;
  return warming_up_;
}

Validator::Fault Validator::mend(Event& event) noexcept {
  if (!is_stamp(event.t)) return Fault::bad_record;
  const bool inside = event.x <= max_x_ && event.y <= max_y_;
  if (!inside && config_.on_bad != OnBad::clamp) return Fault::out_of_bounds;

  std::int64_t t = event.t + clock_offset_us_;
  const std::int64_t back = last_us_ - t;
  const bool new_epoch = back >= kNewEpoch_us;
  const bool lifted = back > 0 && !new_epoch;
  if (lifted && back > config_.reorder_tolerance_us && config_.on_bad != OnBad::clamp) {
    return Fault::nonmonotonic;
  }
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
                      "; sort the events, raise reorder_tolerance_us, or drop with on_bad = drop");
}

}  // namespace asap
