#include "asap/packager/packager.hpp"

#include <algorithm>

namespace asap {
namespace {

constexpr std::int64_t kSmoothingNs = 20'000'000;

// Of one time in a package: steps of the table, each of which a stratum may cut.
constexpr std::size_t kMostRuns = ArrivalTimes::kSteps + AnytimePlan::kMostStrata;

constexpr std::int64_t kGraceShare = 100;  // of the latency bound: an outage is longer than that

// Waiting events are in time order, so an exact count by time is a binary search.
class RingCounts final : public BacklogCounts {
 public:
  RingCounts(const EventPieces& waiting, const EventTimes& times, std::uint64_t head,
             std::int64_t now_ns)
      : waiting_(waiting), times_(times), head_(head), now_ns_(now_ns) {}

  std::size_t before(std::int64_t time_ns) const noexcept override {
    return times_.before(time_ns, waiting_, head_);
  }

  std::size_t about_before(std::int64_t time_ns) const noexcept override {
    return times_.about_before(time_ns, now_ns_, waiting_, head_);
  }

 private:
  const EventPieces& waiting_;
  const EventTimes& times_;
  const std::uint64_t head_;
  const std::int64_t now_ns_;
};

double fraction(std::size_t kept, std::size_t offered) noexcept {
  return kept == offered ? 1.0 : static_cast<double>(kept) / static_cast<double>(offered);
}

EventPieces part_of(const EventPieces& pieces, std::size_t begin, std::size_t end) noexcept {
  const std::size_t wrap = pieces.first.size();
  const std::size_t first = std::min(begin, wrap);
  const std::size_t second = std::max(begin, wrap);
  return {pieces.first.subspan(first, std::min(end, wrap) - first),
          pieces.second.subspan(second - wrap, std::max(end, wrap) - second)};
}

}  // namespace

Packager::Packager(EventBuffer& buffer, const EventTimes& times, Scheme& scheme,
                   Telemetry& telemetry, PackagerConfig config)
    : buffer_(buffer),
      scheme_(scheme),
      telemetry_(telemetry),
      times_(times),
      filter_(config.seed),
      config_(config),
      kept_(std::make_unique_for_overwrite<Event[]>(buffer.capacity())),
      numbers_(std::make_unique_for_overwrite<std::uint64_t[]>(
          AnytimePlan::longest_stratum(buffer.capacity()))),
      kept_times_(times.by_arrival() ? kMostRuns : 0) {
  scheme_.reset(config.execution);
}

Packager::Next Packager::next(std::int64_t now_ns) noexcept {
  for (;;) {
    const bool ended = buffer_.closed();  // before the peek, which then sees all there will be
    const EventPieces waiting = buffer_.peek();
    if (waiting.size() == 0) {
      return {.step = ended ? Step::ended : Step::wait, .until_tail = buffer_.head() + 1};
    }
    const Decision decision = ask(waiting, times_.of(waiting[0], buffer_.head()), now_ns, ended);
    if (!decision.takes) {
      return {.step = Step::wait,
              .until_ns = decision.until_ns,
              .until_tail = buffer_.head() + decision.until_count};
    }
    if (decision.stale > 0) drop_stale(decision.stale);
    if (decision.raw == 0) continue;  // to be asked again about what is left

    Package package = open(decision, now_ns);
    if (!is_anytime_) {
      thin(package, 0, decision.raw, KeepThreshold::clamped(decision.keep));
      if (package.events.empty()) {
        complete(package, now_ns);
        continue;
      }
      package.gamma = fraction(package.events.size(), package.offered);
    }
    package.keep = smoothed_keep(package.gamma, now_ns);
    return {.step = Step::package, .package = package};
  }
}

Decision Packager::ask(const EventPieces& waiting, std::int64_t oldest_ns, std::int64_t now_ns,
                       bool ended) noexcept {
  const std::int64_t flush_ns = config_.flush ? oldest_ns + telemetry_.latency.bound_ns() : kNever;
  const bool due = ended || now_ns >= flush_ns || waiting.size() == buffer_.capacity() ||
                   buffer_.head() < flush_until_;
  const RingCounts counts(waiting, times_, buffer_.head(), now_ns);
  Decision decision = scheme_.decide({.count = waiting.size(),
                                      .now_ns = now_ns,
                                      .oldest_ns = oldest_ns,
                                      .previous_start_ns = previous_start_ns_,
                                      .due = due,
                                      .counts = counts});
  if (!decision.takes && due) decision = Decision::take(waiting.size());
  if (decision.takes) {
    decision.stale = std::min(decision.stale, waiting.size());
    if (decision.stale == 0) decision.raw = std::max<std::size_t>(decision.raw, 1);
    decision.raw = std::min(decision.raw, waiting.size() - decision.stale);
    decision.keep = decision.keep < 1.0 ? std::max(decision.keep, 0.0) : 1.0;
  } else {
    // A wait that is over already would not let time pass.
    decision.until_ns = std::clamp(decision.until_ns, now_ns + 1, flush_ns);
    decision.until_count =
        std::clamp<std::size_t>(decision.until_count, waiting.size() + 1, buffer_.capacity());
  }
  return decision;
}

void Packager::drop_stale(std::size_t count) noexcept {
  const EventPieces stale = buffer_.peek(count);
  const std::uint64_t head = buffer_.head();
  rate_meter_.observe(count, times_.of(stale[0], head),
                      times_.of(stale[count - 1], head + count - 1));
  filter_.skip(count);
  consume(count);
  telemetry_.stale += count;
  stale_since_package_ += count;
}

Package Packager::open(const Decision& decision, std::int64_t now_ns) noexcept {
  raw_ = buffer_.peek(decision.raw);
  handed_out_ = 0;
  kept_times_.clear();
  is_anytime_ = config_.execution == Execution::anytime && decision.budget_ns != kNever;
  if (is_anytime_) {
    plan_ = AnytimePlan(decision, now_ns, telemetry_.latency.bound_ns() / kGraceShare);
  }
  return {.events = {},
          .index = packages_,
          .gamma = decision.keep,
          .raw = 0,
          .offered = offered_without_package_,
          .stale_before = stale_since_package_,
          .overflow_before = buffer_.overflow() - overflow_reported_,
          .start_ns = now_ns};
}

EventSpan Packager::stratum(Package& package, std::int64_t now_ns) noexcept {
  while (is_anytime_) {
    const std::size_t size = package.events.size() - handed_out_;
    const AnytimePlan::Stratum stratum = plan_.next(now_ns, size);
    handed_out_ = package.events.size();
    if (stratum.begin == stratum.end) {
      package.gamma = fraction(package.events.size(), package.offered);
      return {};
    }
    const EventSpan kept = thin(package, stratum.begin, stratum.end, threshold_of(stratum));
    if (!kept.empty()) return kept;
  }
  const EventSpan rest = package.events.subspan(handed_out_);
  handed_out_ = package.events.size();
  return rest;
}

// In the last stratum no clock makes up for a chance in the number of events: it is kept to.
KeepThreshold Packager::threshold_of(const AnytimePlan::Stratum& stratum) noexcept {
  if (!stratum.is_last) return KeepThreshold::clamped(stratum.keep);
  constexpr double kRounding = 1e-6;
  const std::size_t raw = stratum.end - stratum.begin;
  const double size = stratum.keep * static_cast<double>(raw) + kRounding;
  return filter_.keeping(static_cast<std::size_t>(size), raw, numbers_.get());
}

// Keeps some of the package's raw events [begin, end), which follow those before.
EventSpan Packager::thin(Package& package, std::size_t begin, std::size_t end,
                         KeepThreshold threshold) noexcept {
  const EventPieces raw = part_of(raw_, begin, end);
  const std::uint64_t head = buffer_.head();
  const std::size_t before = package.events.size();
  package.raw = end;
  package.offered = end + offered_without_package_;
  const EventSpan slice = raw.second.empty() ? raw.first : raw.second;
  const bool follows = before == 0 || package.events.data() + before == slice.data();
  if (threshold.keeps_all() && follows && (raw.first.empty() || raw.second.empty())) {
    filter_.skip(slice.size());  // a slice of the ring: the consumer owns it until it is consumed
    package.events = {before == 0 ? slice.data() : package.events.data(), before + slice.size()};
    for (std::size_t at = begin; times_.by_arrival() && at < end;) {
      const std::int64_t time_ns = times_.of(raw_[at], head + at);
      at = times_.same_until(head + at, head + end) - head;
      kept_times_.note(before + (at - begin), time_ns);
    }
  } else {
    if (before > 0 && package.events.data() != kept_.get()) {
      std::copy(package.events.begin(), package.events.end(), kept_.get());
    }
    std::size_t size = before;
    for (std::size_t at = begin; at < end;) {
      const std::size_t until = times_.same_until(head + at, head + end) - head;
      const EventPieces together = part_of(raw_, at, until);
      size += filter_.apply(together.first, threshold, kept_.get() + size);
      size += filter_.apply(together.second, threshold, kept_.get() + size);
      if (times_.by_arrival()) kept_times_.note(size, times_.of(raw_[at], head + at));
      at = until;
    }
    package.events = {kept_.get(), size};
  }
  return package.events.subspan(before);
}

// All raw events of the package have been decided, none is kept: they count to the next package.
void Packager::discard_all(const Package& package, std::int64_t end_ns) noexcept {
  telemetry_.discarded += package.raw;
  offered_without_package_ += package.raw;
  consume(package.raw);
  scheme_.observe({.size = 0,
                   .raw = package.raw,
                   .span_ns = 0,
                   .start_ns = package.start_ns,
                   .processing_ns = end_ns - package.start_ns});
}

double Packager::smoothed_keep(double gamma, std::int64_t now_ns) const noexcept {
  if (gamma == keep_ || previous_start_ns_ == kLongAgo) return gamma;
  const auto elapsed = static_cast<double>(now_ns - previous_start_ns_);
  const double weight = elapsed / (elapsed + static_cast<double>(kSmoothingNs));
  return keep_ + (gamma - keep_) * weight;
}

// Returns the time of the oldest event.
std::int64_t Packager::record_latencies(EventSpan events, std::int64_t end_ns) noexcept {
  if (!times_.by_arrival()) {
    LatencyHistogram::Batch latencies(telemetry_.latency);
    const TimeAxis axis_here = axis();  // in registers
    for (const Event& event : events) latencies.record(end_ns - axis_here.to_ns(event.t));
    return axis().to_ns(events.front().t);
  }
  std::size_t at = 0;
  for (const KeptTimes::Run& run : kept_times_.runs()) {
    telemetry_.latency.record(end_ns - run.time_ns, run.end - at);
    at = run.end;
  }
  return kept_times_.runs().front().time_ns;
}

void Packager::consume(std::size_t count) noexcept {
  buffer_.consume(count);
  times_.release(buffer_.head());
}

void Packager::complete(const Package& package, std::int64_t end_ns) noexcept {
  const std::uint64_t head = buffer_.head();
  rate_meter_.observe(package.raw, times_.of(raw_[0], head),
                      times_.of(raw_[package.raw - 1], head + package.raw - 1));
  if (package.events.empty()) return discard_all(package, end_ns);
  const std::int64_t oldest_ns = record_latencies(package.events, end_ns);
  const std::size_t size = package.events.size();
  const std::int64_t processing_ns = end_ns - package.start_ns;
  const RateMeter::Window entered = rate_meter_.window();
  telemetry_.log.append({.start_ns = package.start_ns,
                         .processing_ns = processing_ns,
                         .oldest_ns = oldest_ns,
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
                   .span_ns = axis().to_ns(package.t_last()) - axis().to_ns(package.t_first()),
                   .start_ns = package.start_ns,
                   .processing_ns = processing_ns});
  consume(package.raw);
  ++packages_;
  keep_ = smoothed_keep(fraction(size, package.offered), package.start_ns);
  previous_start_ns_ = package.start_ns;
  offered_without_package_ = 0;
  stale_since_package_ = 0;
  overflow_reported_ += package.overflow_before;
}

}  // namespace asap
