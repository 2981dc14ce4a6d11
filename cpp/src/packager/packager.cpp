#include "packager/packager.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

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

  void about_before_each(std::int64_t newest_ns, std::int64_t step_ns,
                         std::span<std::size_t> counts) const noexcept override {
    times_.about_before_each(newest_ns, step_ns, now_ns_, waiting_, head_, counts);
  }

 private:
  const EventPieces& waiting_;
  const EventTimes& times_;
  const std::uint64_t head_;
  const std::int64_t now_ns_;
};

double gamma_of(std::size_t kept, std::size_t seen) noexcept {
  return kept == seen ? 1.0 : static_cast<double>(kept) / static_cast<double>(seen);
}

}  // namespace

Packager::Packager(EventBuffer& buffer, const EventTimes& times, Scheme& scheme,
                   Telemetry& telemetry, PackagerConfig config)
    : buffer_(buffer),
      scheme_(scheme),
      telemetry_(telemetry),
      times_(times),
      config_(std::move(config)),
      thinner_(times_, buffer.capacity(), config_.seed, config_.front_filter, config_.max_copied),
      books_(telemetry, gap_, times_) {
  require(config_.max_copied >= 1, "max_copied", config_.max_copied, "must be at least 1");
  if (config_.prefault) thinner_.prefault();
  scheme_.reset(config_.execution);
}

Packager::Packager(EventBuffer& buffer, Scheme& scheme, Telemetry& telemetry, PackagerConfig config)
    : Packager(buffer, EventTimes(), scheme, telemetry, std::move(config)) {}

std::size_t Packager::memory_bytes(std::size_t capacity, std::size_t max_copied,
                                   bool is_filtered) noexcept {
  return Thinner::memory_bytes(capacity, max_copied, ArrivalTimes::steps_for(capacity),
                               is_filtered);
}

void Packager::reset() {
  thinner_.reset(config_.seed, config_.front_filter);
  gap_ = {};
  std::construct_at(&books_, telemetry_, gap_, times_);
  flush_until_ = 0;
  previous_start_ns_ = kLongAgo;
  untold_ = 0;
  scheme_.reset(config_.execution);
}

void Packager::begin(TimeAxis axis, std::int64_t first_us) noexcept {
  gap_.begin(first_us);
  times_.set_axis(axis);
  telemetry_.log.set_axis(axis);
}

void Packager::set_latency_bound(std::int64_t bound_ns) noexcept {
  telemetry_.latency.set_bound_ns(bound_ns);
  scheme_.set_latency_bound_ns(bound_ns);
}

Packager::Next Packager::next(std::int64_t now_ns, std::uint64_t until) {
  Next next;
  for (;;) {
    const std::uint64_t there = until - buffer_.head();
    // Closed before the peek, which then sees all there will be.
    const bool ended = buffer_.closed() && buffer_.size() <= there;
    const EventPieces waiting = buffer_.peek(there);
    if (config_.kept_mask != nullptr) config_.kept_mask->make_room(waiting.size());
    if (waiting.size() == 0) {
      next.step = ended ? Step::ended : Step::wait;
      next.until_tail = buffer_.head() + 1;
      return next;
    }
    const std::int64_t oldest_ns = times_.of(waiting[0], buffer_.head());
    if (config_.drop_oldest && waiting.size() == buffer_.capacity() && waiting.size() > 1) {
      books_.overflow(leaving(waiting, waiting.size() / 2, oldest_ns));
      pass_over(waiting.size() / 2);
      continue;
    }
    const Decision decision = ask(waiting, oldest_ns, now_ns, ended);
    if (!decision.takes) {
      next.until_ns = decision.until_ns;
      next.until_tail = buffer_.head() + decision.until_count;
      return next;
    }
    if (decision.stale > 0) {
      books_.stale(leaving(waiting, decision.stale, oldest_ns));
      pass_over(decision.stale);
    }
    if (decision.raw == 0) continue;  // to be asked again about what is left

    const bool is_first = decision.stale == 0;
    const EventPieces raw = is_first ? waiting.oldest(decision.raw) : buffer_.peek(decision.raw);
    oldest_ns_ = is_first ? oldest_ns : times_.of(raw[0], buffer_.head());
    open(next.package, raw, decision, now_ns);
    if (!is_anytime_) {
      if (decision.budget_ns == kNever || decision.gamma == 1.0) {
        add(next.package, 0, decision.raw, {.gamma = decision.gamma});
      } else {
        add_planned(next.package, decision);
      }
      if (next.package.events.empty()) {
        complete(next.package, now_ns);
        continue;
      }
      next.package.gamma = tell(next.package.events.size());
    }
    next.step = Step::package;
    return next;
  }
}

inline Decision Packager::ask(const EventPieces& waiting, std::int64_t oldest_ns,
                              std::int64_t now_ns, bool ended) noexcept {
  const std::uint64_t head = buffer_.head();
  const std::int64_t flush_ns = config_.flush ? oldest_ns + telemetry_.latency.bound_ns() : kNever;
  const bool due =
      ended || now_ns >= flush_ns || waiting.size() == buffer_.capacity() || head < flush_until_;
  const RingCounts counts(waiting, times_, head, now_ns);
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
    decision.gamma = decision.gamma < 1.0 ? std::max(decision.gamma, 0.0) : 1.0;
  } else {
    // A wait that is over already would not let time pass.
    decision.until_ns = std::clamp(decision.until_ns, now_ns + 1, flush_ns);
    decision.until_count =
        std::clamp<std::size_t>(decision.until_count, waiting.size() + 1, buffer_.capacity());
  }
  return decision;
}

inline void Packager::open(Package& package, const EventPieces& raw, const Decision& decision,
                           std::int64_t now_ns) noexcept {
  handed_out_ = 0;
  told_ = 0;
  thinner_.begin(raw, buffer_.head());
  is_anytime_ = config_.execution == Execution::anytime && decision.budget_ns != kNever;
  if (is_anytime_) {
    plan_ = AnytimePlan(decision, now_ns, telemetry_.latency.bound_ns() / kGraceShare);
  }
  books_.open(package, now_ns, buffer_.overflow());
}

EventSpan Packager::stratum(Package& package, std::int64_t now_ns) {
  while (is_anytime_) {
    const std::size_t size = package.events.size() - handed_out_;
    const AnytimePlan::Stratum stratum = plan_.next(now_ns, size);
    handed_out_ = package.events.size();
    if (stratum.begin == stratum.end) {
      package.gamma = gamma_of(handed_out_, told_);
      return {};
    }
    // In the last stratum no clock makes up for a chance in the number of events.
    const EventSpan kept = add(package, stratum.begin, stratum.end,
                               {.gamma = stratum.gamma, .exactly = stratum.is_last});
    if (package.raw < stratum.end) plan_ = {};  // it is full
    if (kept.empty()) continue;
    package.gamma = tell(kept.size());
    return kept;
  }
  const EventSpan rest = package.events.subspan(handed_out_);
  handed_out_ = package.events.size();
  return rest;
}

// As many events as are planned: the last part makes up for the chance in those before it.
void Packager::add_planned(Package& package, const Decision& decision) {
  const std::size_t raw = decision.raw;
  const std::size_t last = std::min(AnytimePlan::longest_stratum(raw), raw);
  if (last < raw) add(package, 0, raw - last, {.gamma = decision.gamma});
  if (package.raw < raw - last) return;  // it is full
  const double planned = decision.gamma * static_cast<double>(raw);
  const double left = std::max(planned - static_cast<double>(package.events.size()), 0.0);
  add(package, raw - last, raw, {.gamma = left / static_cast<double>(last), .exactly = true});
}

// Decides the package's raw events [begin, end), which follow those before, or as many as fit.
inline EventSpan Packager::add(Package& package, std::size_t begin, std::size_t end, Share share) {
  const EventSpan kept = thinner_.decide(begin, end, share);
  const std::size_t seen = package.offered - package.filtered;
  const std::size_t raw = thinner_.decided();
  package.events = thinner_.events();
  books_.add(package, raw, buffer_.head() + raw - 1, thinner_.filtered());
  untold_ += package.offered - package.filtered - seen;
  return kept;
}

// Gamma of so many kept events, which are handed out now.
inline double Packager::tell(std::size_t kept) noexcept {
  told_ += untold_;
  return gamma_of(kept, std::exchange(untold_, 0));
}

inline Books::Left Packager::leaving(const EventPieces& waiting, std::size_t count,
                                     std::int64_t oldest_ns) const noexcept {
  const std::uint64_t last = buffer_.head() + count - 1;
  return {.count = count,
          .waiting = waiting,
          .oldest_ns = oldest_ns,
          .newest_ns = count == 1 ? oldest_ns : times_.of(waiting[count - 1], last)};
}

// The oldest leave the ring undecided.
void Packager::pass_over(std::size_t count) noexcept {
  thinner_.skip(count);
  if (config_.kept_mask != nullptr) config_.kept_mask->passed_over(count);
  consume(count);
}

void Packager::complete(const Package& package, std::int64_t end_ns) noexcept {
  const Books::Left left = leaving(thinner_.raw(), package.raw, oldest_ns_);
  if (config_.kept_mask != nullptr) {
    config_.kept_mask->packaged(thinner_.raw(), package.raw, package.events);
  }
  if (package.events.empty()) {
    books_.discarded(package, left);
  } else {
    books_.delivered(package, left, end_ns, thinner_.arrivals());
    previous_start_ns_ = package.start_ns;
  }
  observe(package, end_ns);
  consume(package.raw);  // last: then the producer may overwrite the events
}

inline void Packager::observe(const Package& package, std::int64_t end_ns) noexcept {
  const EventSpan events = package.events;
  const TimeAxis& axis = times_.axis();
  Outcome outcome{
      .size = events.size(),
      .raw = package.raw,
      .span_ns = events.size() < 2 ? 0 : axis.to_ns(events.back().t) - axis.to_ns(events.front().t),
      .start_ns = package.start_ns,
      .processing_ns = end_ns - package.start_ns};
  if (is_anytime_ && !events.empty()) {
    outcome.outage_ns = plan_.outage_ns();
    outcome.first_size = plan_.first().size;
    outcome.first_ns = plan_.first().time_ns;
  }
  scheme_.observe(outcome);
}

inline void Packager::consume(std::size_t count) noexcept {
  buffer_.consume(count);
  times_.release(buffer_.head());
}

}  // namespace asap::inline v0_1
