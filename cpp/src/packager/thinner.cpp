#include "packager/thinner.hpp"

#include <algorithm>
#include <utility>

#include "asap/core/nonblocking.hpp"
#include "core/check.hpp"
#include "packager/anytime_plan.hpp"

namespace asap::inline v0_1 {
namespace {

// The most runs of events with one arrival time that a package can have: one for each step of the
// table, and one more for each stratum that begins within a step. 0 where times are stamps.
std::size_t max_runs(std::size_t steps) noexcept {
  return steps > 0 ? steps + AnytimePlan::kMaxStrata : 0;
}

EventPieces part_of(const EventPieces& pieces, std::size_t begin, std::size_t end) noexcept {
  const std::size_t wrap = pieces.first.size();
  const std::size_t first = std::min(begin, wrap);
  const std::size_t second = std::max(begin, wrap);
  return {pieces.first.subspan(first, std::min(end, wrap) - first),
          pieces.second.subspan(second - wrap, std::max(end, wrap) - second)};
}

}  // namespace

Thinner::Thinner(const EventTimes& times, std::size_t capacity, std::uint64_t seed,
                 FrontFilter before, std::size_t max_copied)
    : times_(times),
      before_(std::move(before)),
      gamma_(seed),
      max_copied_(std::min(capacity, max_copied)),
      max_numbers_(AnytimePlan::longest_stratum(max_copied_)),
      kept_(detail::allocate<Event>(max_copied_, "capacity", capacity)),
      numbers_(detail::allocate<std::uint64_t>(max_numbers_, "capacity", capacity)),
      kept_times_(max_runs(times.steps())),
      passed_times_(times.by_arrival() && before_ ? max_runs(times.steps()) : 1) {}

std::size_t Thinner::memory_bytes(std::size_t capacity, std::size_t max_copied, std::size_t steps,
                                  bool is_filtered) noexcept {
  const std::size_t copied = std::min(capacity, max_copied);
  return copied * sizeof(Event) + AnytimePlan::longest_stratum(copied) * sizeof(std::uint64_t) +
         KeptTimes::memory_bytes(max_runs(steps)) +
         KeptTimes::memory_bytes(is_filtered ? max_runs(steps) : 1);
}

void Thinner::prefault() noexcept {
  std::fill_n(kept_.get(), max_copied_, Event{});
  std::fill_n(numbers_.get(), max_numbers_, std::uint64_t{0});
}

EventSpan Thinner::decide_part(std::size_t begin, std::size_t end, Share share) {
  if (before_) return filter_and_thin(begin, end, share);
  const EventPieces raw = part_of(raw_, begin, end);
  const EventSpan slice = raw.first.empty() ? raw.second : raw.first;
  const bool follows = events_.empty() || events_.data() + events_.size() == slice.data();
  const bool is_enough = slice.size() == end - begin || !fits(end - begin);
  if (share.gamma >= 1.0 && follows && is_enough) return take_slice(slice, begin);
  return thin(begin, end, share);
}

// The decided events from `begin` on were all kept and follow the package's first `size` events:
// notes when they came.
void Thinner::note_arrivals(std::size_t begin, std::size_t size) noexcept {
  for (std::size_t at = begin; at < decided_;) {
    const Together together = times_.together(head_ + at, head_ + decided_);
    at = together.until - head_;
    kept_times_.note(size + (at - begin), together.time_ns);
  }
}

EventSpan Thinner::thin(std::size_t begin, std::size_t end, Share share) noexcept {
  decided_ = begin;
  if (is_slice() && !fits(end - begin)) return {};
  leave_the_ring();
  const KeepThreshold bar = threshold(end - begin, share);
  const std::size_t before = events_.size();
  std::size_t size = before;
  for (std::size_t& at = decided_; at < end && size < max_copied_;) {
    const Together together = times_.together(head_ + at, head_ + end);
    const std::size_t until = std::min(together.until - head_, at + (max_copied_ - size));
    const EventPieces raw = part_of(raw_, at, until);
    size += gamma_.apply(raw.first, bar, room_from(size));
    size += gamma_.apply(raw.second, bar, room_from(size));
    if (times_.by_arrival()) kept_times_.note(size, together.time_ns);
    at = until;
  }
  events_ = {kept_.get(), size};
  return events_.subspan(before);
}

// First all of them through the filter in front, so that the share is planned with what has passed.
EventSpan Thinner::filter_and_thin(std::size_t begin, std::size_t end, Share share) {
  const std::size_t before = events_.size();
  end = std::min(end, begin + (max_copied_ - before));
  const std::span<Event> passing = room_from(before);
  std::size_t passed = 0;
  const auto pass = [&](EventSpan events) {
    if (events.empty()) return;
    const std::size_t more = exempt([&] { return before_(events, passing.subspan(passed)); });
    passed += std::min(more, events.size());
  };
  passed_times_.clear();
  for (std::size_t at = begin; at < end;) {
    const Together together = times_.together(head_ + at, head_ + end);
    const EventPieces raw = part_of(raw_, at, together.until - head_);
    pass(raw.first);
    pass(raw.second);
    passed_times_.note(passed, together.time_ns);
    at = together.until - head_;
  }
  decided_ = end;
  filtered_ += end - begin - passed;

  const double wanted = share.gamma * static_cast<double>(end - begin);
  const KeepThreshold bar = threshold(
      passed,
      {.gamma = passed > 0 ? wanted / static_cast<double>(passed) : 1.0, .exactly = share.exactly});
  std::size_t size = before;
  std::size_t at = 0;
  for (const KeptTimes::Run& run : passed_times_.runs()) {
    size += gamma_.apply(passing.subspan(at, run.end - at), bar, room_from(size));
    if (times_.by_arrival()) kept_times_.note(size, run.time_ns);
    at = run.end;
  }
  events_ = {kept_.get(), size};
  return events_.subspan(before);
}

KeepThreshold Thinner::threshold(std::size_t events, Share share) const noexcept {
  if (!share.exactly || share.gamma >= 1.0 || events > max_numbers_) {
    return KeepThreshold::clamped(share.gamma);
  }
  constexpr double kRounding = 1e-6;
  const double size = share.gamma * static_cast<double>(events) + kRounding;
  return gamma_.keeping(static_cast<std::size_t>(size), events, {numbers_.get(), max_numbers_});
}

void Thinner::leave_the_ring() noexcept {
  if (!is_slice()) return;
  std::copy(events_.begin(), events_.end(), kept_.get());
  events_ = {kept_.get(), events_.size()};
}

}  // namespace asap::inline v0_1
