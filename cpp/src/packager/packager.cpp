#include "asap/packager/packager.hpp"

#include <algorithm>

namespace asap {
namespace {

constexpr std::int64_t kSmoothingNs = 20'000'000;

// Waiting events are in time order, so a count by time is a binary search.
class RingCounts final : public BacklogCounts {
 public:
  RingCounts(const EventPieces& waiting, const TimeAxis& axis) : waiting_(waiting), axis_(axis) {}

  std::size_t before(std::int64_t time_ns) const noexcept override {
    const auto is_before = [&](const Event& event) { return axis_.to_ns(event.t) < time_ns; };
    const auto count = [&](EventSpan events) {
      const auto end = std::partition_point(events.begin(), events.end(), is_before);
      return static_cast<std::size_t>(end - events.begin());
    };
    return count(waiting_.first) + count(waiting_.second);
  }

 private:
  const EventPieces& waiting_;
  const TimeAxis& axis_;
};

}  // namespace

Packager::Packager(EventBuffer& buffer, Scheme& scheme, Telemetry& telemetry, std::uint64_t seed)
    : buffer_(buffer),
      scheme_(scheme),
      telemetry_(telemetry),
      filter_(seed),
      kept_(std::make_unique_for_overwrite<Event[]>(buffer.capacity())) {
  scheme_.reset();
}

Packager::Next Packager::next(std::int64_t now_ns) noexcept {
  for (;;) {
    const bool ended = buffer_.closed();  // before the peek, which then sees all there will be
    const EventPieces waiting = buffer_.peek();
    if (waiting.size() == 0) {
      return {.step = ended ? Step::ended : Step::wait, .until_tail = buffer_.head() + 1};
    }
    const std::int64_t oldest_ns = axis_.to_ns(waiting[0].t);
    const Decision decision = ask(waiting, oldest_ns, now_ns, ended);
    if (!decision.takes) {
      return {.step = Step::wait,
              .until_ns = decision.until_ns,
              .until_tail = buffer_.head() + decision.until_count};
    }
    const std::size_t leaving = decision.stale + decision.raw;
    rate_meter_.observe(leaving, oldest_ns, axis_.to_ns(waiting[leaving - 1].t));
    if (decision.stale > 0) drop_stale(decision.stale);
    if (decision.raw == 0) continue;  // all that waited was stale

    const EventPieces raw = buffer_.peek(decision.raw);
    const EventSpan kept = thin(raw, decision.keep);
    if (!kept.empty()) return {.step = Step::package, .package = package(kept, raw, now_ns)};
    discard_all(raw.size(), now_ns);
  }
}

Decision Packager::ask(const EventPieces& waiting, std::int64_t oldest_ns, std::int64_t now_ns,
                       bool ended) noexcept {
  const std::int64_t flush_ns = oldest_ns + telemetry_.latency.bound_ns();
  const bool due = ended || now_ns >= flush_ns || waiting.size() == buffer_.capacity();
  const RingCounts counts(waiting, axis_);
  Decision decision = scheme_.decide({.count = waiting.size(),
                                      .now_ns = now_ns,
                                      .oldest_ns = oldest_ns,
                                      .previous_start_ns = previous_start_ns_,
                                      .due = due,
                                      .counts = counts});
  if (!decision.takes && due) decision = Decision::take(waiting.size());
  if (decision.takes) {
    decision.stale = std::min(decision.stale, waiting.size());
    decision.raw = std::clamp<std::size_t>(decision.raw, 1, waiting.size());
    decision.raw = std::min(decision.raw, waiting.size() - decision.stale);
  } else {
    // A wait that is over already would not let time pass.
    decision.until_ns = std::clamp(decision.until_ns, now_ns + 1, flush_ns);
    decision.until_count =
        std::clamp<std::size_t>(decision.until_count, waiting.size() + 1, buffer_.capacity());
  }
  return decision;
}

void Packager::drop_stale(std::size_t count) noexcept {
  filter_.skip(count);
  buffer_.consume(count);
  telemetry_.stale += count;
  stale_since_package_ += count;
}

EventSpan Packager::thin(const EventPieces& raw, double keep) noexcept {
  const KeepThreshold threshold = KeepThreshold::clamped(keep);
  if (threshold.keeps_all() && raw.second.empty()) {
    filter_.skip(raw.first.size());
    return raw.first;  // a slice of the ring: the consumer owns it until it is consumed
  }
  std::size_t size = filter_.apply(raw.first, threshold, kept_.get());
  size += filter_.apply(raw.second, threshold, kept_.get() + size);
  return {kept_.get(), size};
}

Package Packager::package(EventSpan kept, const EventPieces& raw, std::int64_t now_ns) noexcept {
  const std::size_t offered = raw.size() + offered_without_package_;
  const double gamma = kept.size() == offered
                           ? 1.0
                           : static_cast<double>(kept.size()) / static_cast<double>(offered);
  smooth_keep(gamma, now_ns);
  return {.events = kept,
          .index = packages_,
          .gamma = gamma,
          .keep = keep_,
          .raw = raw.size(),
          .offered = offered,
          .stale_before = stale_since_package_,
          .overflow_before = buffer_.overflow() - overflow_reported_,
          .start_ns = now_ns};
}

void Packager::discard_all(std::size_t raw, std::int64_t now_ns) noexcept {
  telemetry_.discarded += raw;
  offered_without_package_ += raw;
  buffer_.consume(raw);
  scheme_.observe({.size = 0, .raw = raw, .span_ns = 0, .start_ns = now_ns, .processing_ns = 0});
}

void Packager::smooth_keep(double gamma, std::int64_t now_ns) noexcept {
  if (gamma == keep_) return;
  if (previous_start_ns_ == kLongAgo) {
    keep_ = gamma;
    return;
  }
  const auto elapsed = static_cast<double>(now_ns - previous_start_ns_);
  const double weight = elapsed / (elapsed + static_cast<double>(kSmoothingNs));
  keep_ += (gamma - keep_) * weight;
}

void Packager::complete(const Package& package, std::int64_t end_ns) noexcept {
  for (const Event& event : package.events) {
    telemetry_.latency.record(end_ns - axis_.to_ns(event.t));
  }
  const std::size_t size = package.events.size();
  const std::int64_t processing_ns = end_ns - package.start_ns;
  const RateMeter::Window entered = rate_meter_.window();
  telemetry_.log.append({.start_ns = package.start_ns,
                         .processing_ns = processing_ns,
                         .t_first = package.t_first(),
                         .t_last = package.t_last(),
                         .offered = package.offered,
                         .size = size,
                         .stale = package.stale_before,
                         .overflow = package.overflow_before,
                         .rate_events = entered.events,
                         .rate_ns = entered.ns});
  telemetry_.delivered += size;
  telemetry_.discarded += package.raw - size;
  scheme_.observe({.size = size,
                   .raw = package.raw,
                   .span_ns = axis_.to_ns(package.t_last()) - axis_.to_ns(package.t_first()),
                   .start_ns = package.start_ns,
                   .processing_ns = processing_ns});
  buffer_.consume(package.raw);
  ++packages_;
  previous_start_ns_ = package.start_ns;
  offered_without_package_ = 0;
  stale_since_package_ = 0;
  overflow_reported_ += package.overflow_before;
}

}  // namespace asap
