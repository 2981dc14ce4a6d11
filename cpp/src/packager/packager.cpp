#include "asap/packager/packager.hpp"

#include <algorithm>
#include <utility>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kSmoothingNs = 20'000'000;

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

// Kept by the gamma filter, of what came to it.
double gamma_of(const Package& package) noexcept {
  const std::size_t kept = package.events.size();
  const std::size_t passed = package.offered - package.filtered;
  return kept == passed ? 1.0 : static_cast<double>(kept) / static_cast<double>(passed);
}

}  // namespace

Packager::Packager(EventBuffer& buffer, const EventTimes& times, Scheme& scheme,
                   Telemetry& telemetry, PackagerConfig config)
    : buffer_(buffer),
      scheme_(scheme),
      telemetry_(telemetry),
      times_(times),
      config_(std::move(config)),
      thinner_(times_, buffer.capacity(), config_.seed, config_.before, config_.most_copied) {
  require(config_.most_copied >= 1, "most_copied", config_.most_copied, "must be at least 1");
  scheme_.reset(config_.execution);
}

Packager::Next Packager::next(std::int64_t now_ns) {
  for (;;) {
    const bool ended = buffer_.closed();  // before the peek, which then sees all there will be
    const EventPieces waiting = buffer_.peek();
    if (config_.kept_mask != nullptr) config_.kept_mask->make_room(waiting.size());
    if (waiting.size() == 0) {
      return {.step = ended ? Step::ended : Step::wait, .until_tail = buffer_.head() + 1};
    }
    if (config_.drop_oldest && waiting.size() == buffer_.capacity() && waiting.size() > 1) {
      telemetry_.overflow += waiting.size() / 2;
      pass_over(waiting.size() / 2);
      continue;
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
      add(package, 0, decision.raw, {.keep = decision.keep});
      if (package.events.empty()) {
        complete(package, now_ns);
        continue;
      }
      package.gamma = gamma_of(package);
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
  pass_over(count);
  telemetry_.stale += count;
  stale_since_package_ += count;
}

// The oldest leave the ring undecided.
void Packager::pass_over(std::size_t count) noexcept {
  const EventPieces oldest = buffer_.peek(count);
  const std::uint64_t head = buffer_.head();
  rate_meter_.observe(count, times_.of(oldest[0], head),
                      times_.of(oldest[count - 1], head + count - 1));
  thinner_.skip(count);
  if (config_.kept_mask != nullptr) config_.kept_mask->passed_over(count);
  consume(count);
}

Package Packager::open(const Decision& decision, std::int64_t now_ns) noexcept {
  raw_ = buffer_.peek(decision.raw);
  handed_out_ = 0;
  thinner_.begin(raw_, buffer_.head());
  is_anytime_ = config_.execution == Execution::anytime && decision.budget_ns != kNever;
  if (is_anytime_) {
    plan_ = AnytimePlan(decision, now_ns, telemetry_.latency.bound_ns() / kGraceShare);
  }
  return {.events = {},
          .index = packages_,
          .gamma = decision.keep,
          .raw = 0,
          .offered = offered_without_package_,
          .filtered = filtered_without_package_,
          .stale_before = stale_since_package_,
          .overflow_before = overflow() - overflow_reported_,
          .start_ns = now_ns};
}

EventSpan Packager::stratum(Package& package, std::int64_t now_ns) {
  while (is_anytime_) {
    const std::size_t size = package.events.size() - handed_out_;
    const AnytimePlan::Stratum stratum = plan_.next(now_ns, size);
    handed_out_ = package.events.size();
    if (stratum.begin == stratum.end) {
      package.gamma = gamma_of(package);
      return {};
    }
    // In the last stratum no clock makes up for a chance in the number of events.
    const EventSpan kept = add(package, stratum.begin, stratum.end,
                               {.keep = stratum.keep, .exactly = stratum.is_last});
    if (package.raw < stratum.end) plan_ = {};  // it is full
    if (!kept.empty()) return kept;
  }
  const EventSpan rest = package.events.subspan(handed_out_);
  handed_out_ = package.events.size();
  return rest;
}

// Decides the package's raw events [begin, end), which follow those before, or as many as fit.
EventSpan Packager::add(Package& package, std::size_t begin, std::size_t end, Share share) {
  const EventSpan kept = thinner_.decide(begin, end, share);
  package.events = thinner_.events();
  package.raw = thinner_.decided();
  const std::uint64_t last = buffer_.head() + package.raw - 1;
  const std::uint64_t thinned = times_.thinned(last) - thinned_reported_;
  package.offered = offered_without_package_ + thinned + package.raw;
  package.filtered = filtered_without_package_ + thinner_.filtered();
  return kept;
}

// All raw events of the package have been decided, none is kept: they count to the next package.
void Packager::discard_all(const Package& package, std::int64_t end_ns) noexcept {
  telemetry_.filtered += thinner_.filtered();
  telemetry_.discarded += package.raw - thinner_.filtered();
  offered_without_package_ = package.offered;
  filtered_without_package_ = package.filtered;
  consume(package.raw);
  scheme_.observe({.size = 0,
                   .raw = package.raw,
                   .span_ns = 0,
                   .start_ns = package.start_ns,
                   .processing_ns = end_ns - package.start_ns});
}

double Packager::smoothed_keep(double gamma, std::int64_t now_ns) const noexcept {
  if (gamma == keep_ || previous_start_ns_ == kLongAgo) return gamma;
  const auto elapsed =
      static_cast<double>(std::max(now_ns, previous_start_ns_) - previous_start_ns_);
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
  for (const KeptTimes::Run& run : thinner_.arrivals().runs()) {
    telemetry_.latency.record(end_ns - run.time_ns, run.end - at);
    at = run.end;
  }
  return thinner_.arrivals().runs().front().time_ns;
}

void Packager::consume(std::size_t count) noexcept {
  buffer_.consume(count);
  times_.release(buffer_.head());
}

void Packager::complete(const Package& package, std::int64_t end_ns) noexcept {
  const std::uint64_t head = buffer_.head();
  const std::size_t came = package.offered - offered_without_package_;  // the thinned out included
  rate_meter_.observe(came, times_.of(raw_[0], head),
                      times_.of(raw_[package.raw - 1], head + package.raw - 1));
  thinned_reported_ += came - package.raw;
  if (config_.kept_mask != nullptr) {
    config_.kept_mask->packaged(raw_, package.raw, package.events);
  }
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
                         .filtered = package.filtered,
                         .size = size,
                         .stale = package.stale_before,
                         .overflow = package.overflow_before,
                         .rate_events = entered.events,
                         .rate_ns = entered.ns});
  telemetry_.delivered += size;
  telemetry_.filtered += thinner_.filtered();
  telemetry_.discarded += package.raw - thinner_.filtered() - size;
  scheme_.observe({.size = size,
                   .raw = package.raw,
                   .span_ns = axis().to_ns(package.t_last()) - axis().to_ns(package.t_first()),
                   .start_ns = package.start_ns,
                   .processing_ns = processing_ns,
                   .outage_ns = is_anytime_ ? plan_.outage_ns() : 0,
                   .first_size = is_anytime_ ? plan_.first().size : 0,
                   .first_ns = is_anytime_ ? plan_.first().time_ns : 0});
  consume(package.raw);
  ++packages_;
  keep_ = smoothed_keep(gamma_of(package), package.start_ns);
  previous_start_ns_ = package.start_ns;
  offered_without_package_ = 0;
  filtered_without_package_ = 0;
  stale_since_package_ = 0;
  overflow_reported_ += package.overflow_before;
}

}  // namespace asap
