#include "live_shadow.hpp"

#include <algorithm>
#include <cmath>

#include "buffer/arrival_times.hpp"
#include "scheme_laws.hpp"

namespace asap::simulation {
namespace {

constexpr std::int64_t kCalmBounds = 20;
constexpr std::uint64_t kCalmPackages = 60;

template <class Number>
double number(Number value) noexcept {
  return static_cast<double>(value);
}

// The rule of Intake: of m events that leave less than a quarter q free, r slots become
// r / (1 + r m / q^2).
double admitted(std::size_t offered, std::size_t room, std::size_t capacity) noexcept {
  const double quarter = number(capacity) / 4;
  const double whole = std::clamp(number(room) - quarter, 0.0, number(offered));
  const double rest = number(offered) - whole;
  const double left = number(room) - whole;
  return whole + left - left / (1.0 + left * rest / (quarter * quarter));
}

}  // namespace

LiveShadow::LiveShadow(const Setup& setup, const LiveSetup& live, std::int64_t bound_ns,
                       Journal& journal, Tally& tally)
    : live_(live), setup_(setup), journal_(journal), tally_(tally), longest_bound_ns_(bound_ns) {
  setup_.latency_ns = asked_.bound_ns = looked_.bound_ns = heeded_bound_ns_ = bound_ns;
}

// ---- the world

void LiveShadow::begins(const Event& first, std::int64_t came_ns, std::int64_t now_ns) {
  has_begun_ = true;
  arrival_ns_ = TimeAxis(first.t, 1.0).to_ns(first.t);
  offset_ns_ = arrival_ns_ - came_ns;
  stall_.looks_up(now_ns, false, heeded_bound_ns_);
}

void LiveShadow::pushed(const Pushed& pushed, const Ledger& before, const Ledger& after) {
  if (pushed.events.empty()) return;
  arrival_ns_ = std::max(arrival_ns_, run_ns(pushed.came_ns));
  const std::uint64_t taken = after.pending - before.pending;
  const std::uint64_t thinned = after.discarded - before.discarded;
  const std::uint64_t overflow = after.overflow - before.overflow;
  journal_.equal(Law::ledger, taken + thinned + overflow, pushed.events.size(), "pushed");
  if (journal_.failed()) return;
  if (pushed.is_reset) {
    asked_.flush_min = held_.size();
    asked_.flush_max = held_.size() + taken;
    may_be_woken_ = true;
  }
  hold_admission(pushed.events.size(), taken, thinned, overflow);
  const std::uint64_t first = sent_.size();
  sent_.insert(sent_.end(), pushed.events.begin(), pushed.events.end());
  numbers_.insert(numbers_.end(), pushed.numbers.begin(), pushed.numbers.end());
  for (std::uint64_t i = 0; i < taken; ++i) {  // the newest are lost, or nobody knows which
    held_.push_back({thinned == 0 ? first + i : first, thinned == 0 ? first + i + 1 : sent_.size(),
                     arrival_ns_});
  }
  thinned_ += thinned;
  overflow_ += overflow;
  max_waiting_ = std::max(max_waiting_, waiting());
}

// Which events give way, by WhenFull.
void LiveShadow::hold_admission(std::size_t offered, std::uint64_t taken, std::uint64_t thinned,
                                std::uint64_t overflow) {
  const std::size_t capacity = setup_.capacity;
  const std::size_t room = capacity - waiting();
  const bool is_full = taken == room;
  journal_.hold(Law::pending, taken <= room, "more than there is room", number(taken),
                number(room));
  journal_.hold(Law::ledger, overflow == 0 || is_full, "overflow, though there is room",
                number(overflow), number(room - taken));
  if (live_.when_full != WhenFull::thin) {
    journal_.equal(Law::ledger, taken, std::min(offered, room), "events that fit");
    return journal_.equal(Law::ledger, thinned, 0u, "thinned by a rule that does not");
  }
  const std::size_t quarter = capacity / 4;
  const bool leaves_a_quarter = room >= offered + quarter;
  journal_.hold(Law::gamma, thinned == 0 || !leaves_a_quarter, "thinned, though there is room",
                number(room), number(offered + quarter));
  // A push with bad events comes in parts, and the last may find full what the first have filled.
  const bool is_filled = capacity < 4096 || room < 256 || offered > quarter * quarter / 16;
  journal_.hold(Law::ledger, overflow == 0 || room == 0 || is_filled,
                "overflow instead of thinning", number(overflow), number(room));
  constexpr std::size_t kEnough = 64;  // below, what fits cuts off chance
  if (leaves_a_quarter || room < kEnough) return;
  // Over all pushes: one alone says little.
  let_in_ += static_cast<double>(taken);
  let_in_by_law_ += admitted(offered, room, capacity);
  journal_.hold(Law::gamma, std::abs(let_in_ - let_in_by_law_) <= 7 * std::sqrt(let_in_by_law_) + 4,
                "get in by thinning", let_in_, let_in_by_law_);
}

void LiveShadow::flushes() noexcept {
  asked_.flush_min = asked_.flush_max = held_.size();
  may_be_woken_ = true;
}

void LiveShadow::sets_bound(std::int64_t bound_ns) noexcept {
  asked_.bound_ns = bound_ns;
  longest_bound_ns_ = std::max(longest_bound_ns_, bound_ns);
  may_be_woken_ = true;
  unrest();
}

void LiveShadow::unrest() noexcept {
  calm_since_ns_ = run_ns(seen_ns_);
  calm_since_package_ = packages_;
}

void LiveShadow::hold_stalled(bool stalled, std::int64_t now_ns) {
  const bool any = waiting() > 0;
  const bool may = any && !has_slept_ && stall_.may_be_stalled(now_ns, heeded_bound_ns_);
  const bool must = any && !has_slept_ && stall_.must_be_stalled(now_ns, heeded_bound_ns_);
  journal_.hold(Law::liveness, stalled ? may : !must, "stalled", stalled, must);
}

void LiveShadow::hold_ledger(const Ledger& ledger) {
  journal_.hold(Law::ledger, ledger.balanced(), "received = sum of the others",
                static_cast<double>(ledger.received));
  journal_.equal(Law::ledger, ledger.filtered, filtered_all_, "filtered");
  journal_.equal(Law::ledger, ledger.discarded, discarded_ + thinned_, "discarded");
  journal_.equal(Law::ledger, ledger.stale, stale_, "stale");
  journal_.equal(Law::ledger, ledger.overflow, overflow_, "overflow");
  journal_.equal(Law::ledger, ledger.delivered, delivered_, "delivered");
  journal_.equal(Law::pending, ledger.pending, waiting(), "pending");
  journal_.hold(Law::pending, ledger.pending <= setup_.capacity, "pending <= capacity");
}

// ---- the consumer

void LiveShadow::enters(std::int64_t patience_ns) noexcept {
  enters_ = true;
  patience_ns_ = patience_ns;
}

void LiveShadow::saw(std::int64_t now_ns) {
  journal_.hold(Law::protocol, now_ns >= seen_ns_, "the clock goes back");
  seen_ns_ = now_ns;
  if (enters_) entered_ns_ = now_ns;
  if (enters_ || has_slept_) {
    stall_.looks_up(now_ns, enters_ && is_working_, heeded_bound_ns_);
    heeded_bound_ns_ = asked_.bound_ns;
    is_working_ = is_working_ && !enters_;
    waits_ = enters_ = has_slept_ = false;
  } else if (!is_working_) {
    stall_.may_look_up(now_ns);
  }
}

// The consumer's side drops the older half of a ring that it finds full.
void LiveShadow::drop_oldest() noexcept {
  if (live_.when_full != WhenFull::keep_newest || seen() != setup_.capacity || seen() < 2) return;
  overflow_ += seen() / 2;
  head_ += seen() / 2;
}

void LiveShadow::asked(const Backlog& backlog) {
  setup_.latency_ns = looked_.bound_ns;
  drop_oldest();
  journal_.equal(Law::pending, backlog.count, seen(), "waiting events told");
  if (journal_.failed()) return;
  journal_.hold(Law::liveness, !looked_.abandoned, "asked, though abandoned");
  journal_.equal(Law::protocol, backlog.now_ns, run_ns(seen_ns_), "time told");
  journal_.equal(Law::protocol, backlog.previous_start_ns, previous_start_ns_, "previous start");
  const std::int64_t oldest_ns = held_[head_].time_ns;
  const bool is_exact = max_waiting_ + 100 <= ArrivalTimes::steps_for(setup_.capacity) / 2;
  const std::int64_t step_ns = std::max<std::int64_t>(longest_bound_ns_ / 1024, 1);
  journal_.hold(
      Law::age,
      backlog.oldest_ns <= oldest_ns && (!is_exact || oldest_ns - backlog.oldest_ns <= step_ns),
      "oldest time told", number(backlog.oldest_ns), number(oldest_ns));
  const bool is_late = setup_.flush && backlog.now_ns >= backlog.oldest_ns + setup_.latency_ns;
  const bool is_over = asked_.closed && seen() == waiting();
  const bool is_due = is_over || is_late || seen() == setup_.capacity;
  const bool must = is_due || head_ < looked_.flush_min;
  const bool may = is_due || head_ < looked_.flush_max;
  journal_.hold(Law::age, backlog.due ? may : !must, "due", backlog.due, must);
  journal_.equal(Law::age, backlog.counts.before(backlog.oldest_ns), 0u, "older than the oldest");
}

void LiveShadow::decided(const Backlog& backlog, const Decision& decision, const Belief& belief) {
  belief_ = belief;
  keep_ = std::clamp(decision.gamma, 0.0, 1.0);
  hold_decision(setup_, backlog, decision, journal_);
  waits_ = !decision.takes && !backlog.due;
  raw_ = 0;
  if (waits_) {
    const std::int64_t flush_ns = setup_.flush ? backlog.oldest_ns + setup_.latency_ns : kNever;
    until_ns_ = std::min(std::max(decision.until_ns, backlog.now_ns + 1), flush_ns);
    wanted_tail_ = head_ + std::min(std::max(decision.until_count, seen() + 1), setup_.capacity);
    return;
  }
  if (!decision.takes) {
    raw_ = seen();
  } else {
    const std::size_t stale = std::min(decision.stale, seen());
    stale_ += stale;
    stale_since_ += stale;
    head_ += stale;
    raw_ = std::min(std::max<std::size_t>(decision.raw, stale == 0 ? 1 : 0), seen());
  }
  cursor_ = filter_cursor_ = head_;
  kept_ = filtered_ = 0;
  is_anytime_ = setup_.execution == Execution::anytime && decision.takes &&
                decision.budget_ns != kNever && raw_ > 0;
}

void LiveShadow::filters(EventSpan events, std::size_t passed) {
  journal_.hold(Law::identity, filter_cursor_ + events.size() <= head_ + raw_,
                "the filter in front sees more than is taken");
  if (journal_.failed()) return;
  for (const Event& event : events) {
    const Held& held = held_[filter_cursor_++];
    if (held.end - held.begin > 1 || event == sent_[held.begin]) continue;
    return journal_.equal(Law::identity, event.t, sent_[held.begin].t, "the filter in front sees");
  }
  filtered_ += events.size() - passed;
}

void LiveShadow::part(const Package& package, std::size_t position) {
  if (!package.continues) {
    journal_.equal(Law::protocol, package.index, packages_, "index of a package");
    journal_.equal(Law::protocol, package.start_ns, run_ns(seen_ns_), "start of a package");
    journal_.equal(Law::ledger, package.stale_before, stale_since_, "stale before");
    journal_.hold(Law::ledger, package.overflow_before <= overflow_ - overflow_reported_,
                  "overflow before");
    overflow_reported_ += package.overflow_before;
  }
  journal_.hold(Law::size, !package.events.empty(), "an empty part");
  journal_.hold(Law::size, package.raw <= raw_, "raw events of a package", number(package.raw),
                number(raw_));
  for (const Event& event : package.events) {
    // The next event that is still there and looks like that.
    for (; cursor_ < head_ + raw_; ++cursor_) {
      const Held& held = held_[cursor_];
      std::uint64_t at = std::max(held.begin, next_sent_);
      while (at < held.end && sent_[at] != event) ++at;
      if (at >= held.end) continue;
      next_sent_ = at + 1;
      break;
    }
    if (cursor_ >= head_ + raw_) {
      return journal_.hold(Law::identity, false, "nobody has sent it, or it comes again",
                           number(event.t));
    }
    journal_.hold(Law::kept_set, live_.passes(event), "the filter in front has dropped it");
    if (kept_++ == 0) {
      oldest_ns_ = held_[cursor_].time_ns;
      oldest_number_ = numbers_[held_[cursor_].begin];
    }
    ++cursor_;
  }
  if (position < setup_.faults_end()) unrest();
}

void LiveShadow::told(const Outcome& outcome) {
  journal_.hold(Law::size, outcome.raw <= raw_ && outcome.raw > 0, "raw told", number(outcome.raw),
                number(raw_));
  journal_.equal(Law::size, outcome.size, kept_, "size told");
  if (journal_.failed()) return;
  head_ += outcome.raw;
  filtered_all_ += filtered_;
  discarded_ += outcome.raw - filtered_ - kept_;
  if (is_anytime_) enters_ = is_working_ = true;  // next() is next, also when nothing was kept
  if (kept_ == 0) return;
  journal_.equal(Law::protocol, outcome.processing_ns, run_ns(seen_ns_) - outcome.start_ns,
                 "processing time told");
  delivered_ += kept_;
  if (tally_.fingerprint != nullptr) {
    tally_.fingerprint->feed(static_cast<std::uint64_t>(head_));
    tally_.fingerprint->feed(static_cast<std::uint64_t>(kept_));
    tally_.fingerprint->feed(static_cast<std::uint64_t>(seen_ns_));
  }
  hold_latency(run_ns(seen_ns_) - oldest_ns_, outcome);
  previous_start_ns_ = outcome.start_ns;
  stale_since_ = 0;
  ++packages_;
  ++tally_.packages;
  enters_ = true;
}

// Once nothing has gone wrong for a while, and as far as the scheme knows what a package costs, no
// kept event is later than the bound, or 2.5 fixed costs: but for an event or two, the lags of the
// machine and, where nothing can end a package early, the chance in how many events it keeps.
void LiveShadow::hold_latency(std::int64_t latency_ns, const Outcome& outcome) {
  largest_latency_ns_ = std::max(largest_latency_ns_, latency_ns);
  if (!is_calm()) return;
  const auto kept = static_cast<double>(outcome.size);
  const auto processing_ns = static_cast<double>(outcome.processing_ns);
  const double believed_ns = belief_.alpha_ns + belief_.beta_ns * kept;
  if (std::abs(processing_ns - believed_ns) > 0.05 * believed_ns) return;
  const double bound_ns = std::max(number(setup_.latency_ns), 2.5 * belief_.alpha_ns);
  double events = 2;
  if (setup_.execution == Execution::whole) {
    events += 6 * std::sqrt(number(outcome.raw) * keep_ * (1 - keep_));
  }
  const double limit_ns = 1.03 * bound_ns + events * setup_.beta_ns * (1 + setup_.cost_noise) +
                          8 * number(setup_.lag_ns);
  ++tally_.judged;
  journal_.hold(Law::liveness, number(latency_ns) <= limit_ns, "latency of the oldest kept event",
                number(latency_ns), limit_ns);
}

bool LiveShadow::is_calm() const noexcept {
  const bool keeps_a_bound =
      setup_.scheme.kind == Kind::deadline || setup_.scheme.kind == Kind::dead_beat;
  if (!keeps_a_bound || !setup_.flush || oldest_number_ < setup_.faults_end()) return false;
  const double bound_ns = number(setup_.latency_ns);
  // Not where the consumer is away between two looks, the ring is small or the bound out of reach.
  if (live_.own_loop && live_.patience_ns == 0) return false;
  if (static_cast<double>(setup_.capacity) < 4 * bound_ns / setup_.gap_ns) return false;
  if (20 * setup_.beta_ns > bound_ns || 20 * setup_.alpha_ns > bound_ns) return false;
  return number(oldest_ns_ - calm_since_ns_) >= kCalmBounds * bound_ns &&
         packages_ >= calm_since_package_ + kCalmPackages;
}

void LiveShadow::idles() {
  journal_.hold(Law::protocol, seen_ns_ >= entered_ns_ + patience_ns_, "loses its patience",
                number(seen_ns_ - entered_ns_), number(patience_ns_));
}

void LiveShadow::ended() {
  journal_.hold(Law::liveness, asked_.abandoned || (asked_.closed && waiting() == 0),
                "ended, though events wait", number(waiting()));
}

void LiveShadow::finish(const LatencyHistogram& latency) {
  const std::int64_t max_ns = latency.max_ns();
  journal_.equal(Law::ledger, latency.count(), delivered_, "latencies");
  journal_.hold(Law::age, max_ns >= largest_latency_ns_, "largest latency", number(max_ns),
                number(largest_latency_ns_));
}

// ---- sleep

void LiveShadow::sleeps(std::int64_t deadline_ns) {
  is_asleep_ = has_slept_ = true;
  was_woken_ = may_be_woken_ = false;
  setup_.latency_ns = asked_.bound_ns;
  slept_on_ = asked_;
  if (waiting() == 0) wanted_tail_ = head_ + 1;
  std::int64_t until_ns = entered_ns_ + patience_ns_;
  if (waiting() > 0 && until_ns_ < kNever / 2)
    until_ns = std::min(until_ns, until_ns_ - offset_ns_);
  journal_.equal(Law::age, deadline_ns, until_ns, "sleeps until");
  journal_.hold(Law::liveness, waits_ || waiting() == 0, "sleeps, though nobody said wait");
  journal_.hold(Law::liveness, held_.size() < wanted_tail_, "sleeps, though what it waits for came",
                number(held_.size()), number(wanted_tail_));
  journal_.hold(Law::liveness, head_ >= asked_.flush_min || waiting() == 0,
                "sleeps, though a flush is due");
  journal_.hold(Law::liveness, !asked_.closed && !asked_.abandoned, "sleeps behind the end");
}

void LiveShadow::woken() {
  journal_.hold(Law::protocol, has_slept_, "wakes nobody");  // it may be about to wake up itself
  was_woken_ = true;
}

void LiveShadow::hold_wake() {
  if (!is_asleep_) return;
  const bool must = held_.size() >= wanted_tail_ || (waiting() > 0 && asked_ != slept_on_) ||
                    asked_.closed || asked_.abandoned;
  journal_.hold(Law::liveness, was_woken_ || !must, "a wake-up is lost");
  journal_.hold(Law::protocol, must || may_be_woken_ || !was_woken_, "woken for nothing");
}

}  // namespace asap::simulation
