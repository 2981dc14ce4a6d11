#include "filter/stray_stamps.hpp"

#include <algorithm>
#include <cstdint>

namespace asap::inline v0_1 {

namespace {

// The events of a chunk that the validator would not refuse for anything but their stamps.
std::vector<std::size_t> plausible(const ValidatorConfig& config, EventSpan events) {
  const bool clamps = config.on_bad == OnBad::clamp;
  const auto outside = [clamps](int address, int size) {
    return size != 0 && !clamps && address >= size;
  };
  std::vector<std::size_t> indices;
  indices.reserve(events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& event = events[i];
    if (event.t < -Validator::kMaxRawStamp_us || event.t > Validator::kMaxRawStamp_us) continue;
    if (outside(event.x, config.width) || outside(event.y, config.height)) continue;
    indices.push_back(i);
  }
  return indices;
}

}  // namespace

Checked check_all(Validator& validator, EventSpan events) {
  Checked checked;
  checked.untouched = events.empty();
  validator.check(events, [&](EventSpan run) {
    checked.untouched = run.data() == events.data() && run.size() == events.size();
    if (!checked.untouched) checked.kept.insert(checked.kept.end(), run.begin(), run.end());
  });
  return checked;
}

std::vector<std::size_t> stray_stamps(const Validator& validator, EventSpan events) {
  const std::vector<std::size_t> indices = plausible(validator.config(), events);
  const auto stamp = [&](std::size_t at) { return events[indices[at]].t; };
  const auto near = [](std::int64_t from, std::int64_t to) {
    return from <= to && to - from < Validator::kNewEpoch_us;
  };
  // How many from `at` on are before `t`, counted to `most`.
  const auto count_before = [&](std::size_t at, std::int64_t t, std::size_t max) {
    std::size_t end = at;
    while (end < indices.size() && end - at < max && stamp(end) < t) ++end;
    return end - at;
  };

  std::vector<std::size_t> stray, kept;  // of `indices`; the timestamps of the kept do not decrease
  std::int64_t before = validator.last_us() - validator.clock_offset_us();  // the first kept one
  bool is_first = validator.received() == validator.rejected().total();
  for (std::size_t at = 0; at < indices.size(); ++at) {
    const std::int64_t t = stamp(at), last = kept.empty() ? before : stamp(kept.back());
    if ((kept.empty() && is_first) || t >= last) {
      kept.push_back(at);
      continue;
    }
    if (last - t <= validator.config().reorder_tolerance / std::chrono::microseconds(1)) continue;

    // Either those kept that are after t are ahead, or those from here on that are before `last`
    // are late: the fewer are wrong. A clock that is reset does not go on where it was.
    const auto first_ahead =
        std::upper_bound(kept.begin(), kept.end(), t,
                         [&](std::int64_t time, std::size_t k) { return time < stamp(k); });
    const auto ahead = static_cast<std::size_t>(kept.end() - first_ahead);
    const bool fits = first_ahead != kept.begin() ? near(stamp(*(first_ahead - 1)), t)
                      : is_first                  ? near(t, last)
                                                  : near(before, t);
    const bool far = !near(t, last);
    if (fits && ahead <= kMaxStray && count_before(at, last, ahead + 1) + far > ahead) {
      stray.insert(stray.end(), first_ahead, kept.end());
      kept.erase(first_ahead, kept.end());
      kept.push_back(at);
      continue;
    }
    if (!far) continue;  // late: the validator drops it

    const std::size_t behind = count_before(at, last, kMaxStray + 1);
    const std::size_t next = at + behind;
    if (behind <= kMaxStray && next < indices.size() && near(last, stamp(next))) {
      for (; at < next; ++at) stray.push_back(at);
      --at;
      continue;
    }
    kept.assign(1, at);  // the clock was reset
    is_first = true;
  }
  for (std::size_t& at : stray) at = indices[at];
  std::ranges::sort(stray);
  return stray;
}

Checked check_recorded(Validator& validator, EventSpan events) {
  const Validator fresh = validator;
  Checked checked = check_all(validator, events);
  if (validator.rejected().nonmonotonic == fresh.rejected().nonmonotonic &&
      validator.repaired().lifted_stamps == fresh.repaired().lifted_stamps &&
      validator.clock_resets() == fresh.clock_resets()) {
    return checked;
  }
  const std::vector<std::size_t> stray = stray_stamps(fresh, events);
  if (stray.empty()) return checked;

  std::vector<Event> others;
  others.reserve(events.size() - stray.size());
  std::size_t from = 0;
  for (const std::size_t at : stray) {
    others.insert(others.end(), events.begin() + static_cast<std::ptrdiff_t>(from),
                  events.begin() + static_cast<std::ptrdiff_t>(at));
    from = at + 1;
  }
  others.insert(others.end(), events.begin() + static_cast<std::ptrdiff_t>(from), events.end());
  validator = fresh;
  checked = check_all(validator, others);
  if (checked.untouched) checked = {.untouched = false, .kept = std::move(others)};
  checked.stray = stray.size();
  return checked;
}

}  // namespace asap::inline v0_1
