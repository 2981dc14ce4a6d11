#include "shadow.hpp"

#include <algorithm>
#include <cmath>

#include "scheme_laws.hpp"

namespace asap::simulation {
namespace {

constexpr std::int64_t kStepsPerBound = 1024;  // as in Run
constexpr std::int64_t kGraceShare = 100;      // of the bound: as in Packager

}  // namespace

Shadow::Shadow(const Setup& setup, Journal& journal, Tally& tally)
    : setup_(setup),
      journal_(journal),
      tally_(tally),
      filter_(setup.filter_seed),
      last_t_(std::numeric_limits<std::int64_t>::min()) {
  held_.reserve(setup.events);
}

std::size_t Shadow::pushed(EventSpan events, const std::uint32_t* numbers,
                           std::int64_t arrival_ns) {
  const std::size_t taken = std::min(events.size(), setup_.capacity - waiting());
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (numbers[i] >= setup_.judged_from()) ++tally_.judged;
    if (i < taken) held_.push_back({events[i], numbers[i], time_of(events[i], arrival_ns)});
  }
  overflow_ += events.size() - taken;
  max_waiting_ = std::max(max_waiting_, waiting());
  return taken;
}

std::int64_t Shadow::step_ns() const noexcept {
  if (!setup_.by_arrival) return 0;
  if (max_waiting_ > kExactTable) return kNever / 2;
  return std::max<std::int64_t>(setup_.latency_ns / kStepsPerBound, 1);
}

// Waiting events with an earlier time.
std::size_t Shadow::count_before(std::int64_t time_ns) const noexcept {
  const auto begin = held_.begin() + static_cast<std::ptrdiff_t>(head_);
  const auto end = std::partition_point(begin, held_.end(),
                                        [&](const Held& held) { return held.time_ns < time_ns; });
  return static_cast<std::size_t>(end - begin);
}

void Shadow::asking(std::int64_t now_ns) noexcept {
  now_ns_ = now_ns;
  tail_asked_ = held_.size();
}

void Shadow::asked(const Backlog& backlog, std::uint64_t random) noexcept {
  drop_stale();
  journal_.hold(Law::protocol, !is_open_, "asked while a package is open");
  journal_.equal(Law::pending, backlog.count, waiting(), "waiting events told");
  if (journal_.failed()) return;
  tail_asked_ = held_.size();
  const std::int64_t oldest_ns = held_[head_].time_ns;
  journal_.hold(
      Law::age, backlog.oldest_ns <= oldest_ns && oldest_ns - backlog.oldest_ns <= step_ns(),
      "oldest time told", static_cast<double>(backlog.oldest_ns), static_cast<double>(oldest_ns));
  journal_.equal(Law::protocol, backlog.now_ns, now_ns_, "time told");
  journal_.equal(Law::protocol, backlog.previous_start_ns, previous_start_ns_, "previous start");
  const bool flush_due = setup_.flush && backlog.now_ns >= backlog.oldest_ns + setup_.latency_ns;
  const bool due = closed_ || flush_due || waiting() == setup_.capacity || head_ < flush_until_;
  journal_.hold(Law::age, backlog.due == due, "due", backlog.due, due);
  hold_counts(backlog, random);
}

void Shadow::hold_counts(const Backlog& backlog, std::uint64_t random) noexcept {
  const std::int64_t before_ns =
      static_cast<std::int64_t>(random % static_cast<std::uint64_t>(2 * setup_.latency_ns));
  const std::int64_t time_ns = backlog.now_ns - before_ns;
  const std::int64_t step = std::min(step_ns(), kNever / 4);
  const std::size_t count = backlog.counts.before(time_ns);
  const std::size_t min = count_before(time_ns);
  const std::size_t max = step == 0 ? min : count_before(time_ns + step);
  journal_.hold(Law::age, count >= min && count <= max, "events before a time",
                static_cast<double>(count), static_cast<double>(min));
  journal_.equal(Law::age, backlog.counts.before(backlog.oldest_ns), 0u, "older than the oldest");
  const std::size_t about = backlog.counts.about_before(time_ns);
  journal_.hold(Law::age, about <= backlog.count, "about so many before",
                static_cast<double>(about), static_cast<double>(backlog.count));
  if (setup_.by_arrival || slots_until_ != held_.size()) return;
  const std::int64_t width_ns = std::max<std::int64_t>(setup_.latency_ns / 64, 1);
  const auto slot_of = [&](std::int64_t t) { return t / width_ns - (t % width_ns < 0 ? 1 : 0); };
  const std::int64_t slot = slot_of(time_ns);
  if (slot <= slot_of(held_.back().time_ns) - 126) return;
  // Evenly spread over the slot, the newest of which ends now.
  const std::int64_t begin_ns = slot * width_ns;
  std::int64_t length_ns = width_ns;
  if (slot == slot_of(held_.back().time_ns)) {
    length_ns = std::clamp<std::int64_t>(backlog.now_ns - begin_ns, 1, width_ns);
  }
  const std::size_t from = count_before(begin_ns);
  const std::size_t all = count_before(begin_ns + width_ns) - from;
  const double share =
      std::min(1.0, static_cast<double>(time_ns - begin_ns) / static_cast<double>(length_ns));
  const std::size_t part = static_cast<std::size_t>(share * static_cast<double>(all));
  journal_.equal(Law::age, about, from + part, "about so many before a time");
}

// The packager makes of any answer one that can be carried out.
void Shadow::decided(const Backlog& backlog, Decision decision) noexcept {
  hold_decision(setup_, backlog, decision, journal_);
  if (!decision.takes && backlog.due) decision = Decision::take(backlog.count);
  decision_ = decision;
  if (!decision.takes) {
    const std::int64_t flush_ns = setup_.flush ? backlog.oldest_ns + setup_.latency_ns : kNever;
    decision_.until_ns = std::min(std::max(decision.until_ns, backlog.now_ns + 1), flush_ns);
    decision_.until_count =
        std::min(std::max(decision.until_count, backlog.count + 1), setup_.capacity);
    return;
  }
  decision_.stale = std::min(decision.stale, backlog.count);
  const std::size_t left = backlog.count - decision_.stale;
  const std::size_t min = decision_.stale == 0 ? 1 : 0;
  decision_.raw = std::min(std::max(decision.raw, min), left);
  decision_.gamma = decision.gamma < 1 ? std::max(decision.gamma, 0.0) : 1.0;
  stale_due_ = decision_.stale;
  is_open_ = decision_.raw > 0;
  if (!is_open_) return;

  const std::uint64_t head = head_ + stale_due_;
  raw_ = 0;
  handed_out_ = 0;
  kept_.clear();
  start_ns_ = now_ns_;
  is_anytime_ = setup_.execution == Execution::anytime && decision_.budget_ns != kNever;
  if (is_anytime_) {
    plan_ = AnytimePlan(decision_, now_ns_, setup_.latency_ns / kGraceShare);
    is_planned_out_ = false;
  } else {
    raw_ = decision_.raw;
    keep_whole(head);
  }
}

// Where its time is planned, so is its size: the last raw / 16 + 128 make up for chance.
void Shadow::keep_whole(std::uint64_t head) noexcept {
  const bool is_planned = decision_.budget_ns != kNever && decision_.gamma < 1;
  const std::size_t last = is_planned ? std::min(raw_ / 16 + 128, raw_) : 0;
  filter_.keep(head, head + raw_ - last, decision_.gamma, kept_);
  if (last == 0) return;
  const double wanted = decision_.gamma * static_cast<double>(raw_);
  const double left = std::max(wanted - static_cast<double>(kept_.size()), 0.0);
  filter_.keep_exactly(head + raw_ - last, head + raw_, left / static_cast<double>(last), kept_);
}

void Shadow::drop_stale() noexcept {
  if (stale_due_ == 0) return;
  stale_ += stale_due_;
  stale_since_ += stale_due_;
  leave(stale_due_);
  stale_due_ = 0;
}

void Shadow::leave(std::size_t count) noexcept {
  rate_.observe(count, held_[head_].time_ns, held_[head_ + count - 1].time_ns);
  head_ += count;
}

void Shadow::answered(const Packager::Next& next, const EventBuffer& buffer) {
  drop_stale();
  switch (next.step) {
    case Packager::Step::ended:
      journal_.hold(Law::protocol, closed_ && waiting() == 0, "ended, though events wait",
                    static_cast<double>(waiting()), 0);
      return;
    case Packager::Step::wait: {
      journal_.hold(Law::protocol, !is_open_, "waits with an open package");
      journal_.hold(Law::protocol, next.until_ns > now_ns_, "waits for a time that has passed",
                    static_cast<double>(next.until_ns), static_cast<double>(now_ns_));
      journal_.hold(Law::protocol, next.until_tail > tail_asked_ || waiting() == 0,
                    "waits for events that are there", static_cast<double>(next.until_tail),
                    static_cast<double>(tail_asked_));
      journal_.hold(Law::protocol, next.until_tail <= buffer.head() + buffer.capacity(),
                    "waits for more than the ring holds");
      if (waiting() == 0 || head_ == tail_asked_) return;
      journal_.equal(Law::protocol, next.until_tail, head_ + decision_.until_count,
                     "waits for the events asked for");
      journal_.equal(Law::protocol, next.until_ns, decision_.until_ns, "waits for the time asked");
      if (!setup_.flush) return;
      const std::int64_t latest_ns = held_[head_].time_ns + setup_.latency_ns;
      journal_.hold(Law::age, next.until_ns <= latest_ns, "waits for longer than the bound",
                    static_cast<double>(next.until_ns), static_cast<double>(latest_ns));
      return;
    }
    case Packager::Step::package:
      break;
  }
  const Package& package = next.package;
  journal_.hold(Law::protocol, is_open_, "a package that nobody decided");
  overflow_before_ = overflow_ - overflow_reported_;
  journal_.equal(Law::protocol, package.index, packages_, "index of a package");
  journal_.equal(Law::protocol, package.start_ns, now_ns_, "start of a package");
  journal_.equal(Law::size, package.raw, raw_, "raw events of a package");
  journal_.equal(Law::ledger, package.offered, raw_ + offered_without_, "events offered");
  journal_.equal(Law::ledger, package.stale_before, stale_since_, "stale before");
  journal_.equal(Law::ledger, package.overflow_before, overflow_before_, "overflow before");
  told_ = 0;
  if (is_anytime_) {
    journal_.hold(Law::size, package.events.empty(), "an anytime package begins without events");
    return;
  }
  journal_.equal(Law::kept_set, package.events.size(), kept_.size(), "events kept");
  journal_.hold(Law::size, !package.events.empty(), "an empty package");
  untold_ += raw_;
  hold_gamma(package, kept_.size());
  hold_content(package.events, 0, Law::identity);
}

// So many events were kept of all that thinning has seen since others were handed out.
void Shadow::hold_gamma(const Package& package, std::size_t kept) {
  const double gamma = static_cast<double>(kept) / static_cast<double>(untold_);
  journal_.equal(Law::gamma, package.gamma, gamma, "gamma = kept / seen");
  told_ += untold_;
  untold_ = 0;
}

// The plan's own tests hold its numbers; here: its strata lie side by side, from the first raw
// event of the decision to the last unless time is up.
AnytimePlan::Stratum Shadow::next_stratum(std::int64_t now_ns) {
  const std::size_t size = kept_.size() - handed_out_;
  handed_out_ = kept_.size();
  const AnytimePlan::Stratum stratum = plan_.next(now_ns, size);
  if (stratum.begin == stratum.end) {
    const std::int64_t used_ns = now_ns - start_ns_ - setup_.latency_ns / kGraceShare;
    journal_.hold(Law::size, is_planned_out_ || used_ns > decision_.budget_ns,
                  "a plan that ends early", static_cast<double>(raw_),
                  static_cast<double>(decision_.raw));
    return stratum;
  }
  journal_.hold(Law::size, !is_planned_out_, "a stratum after the last");
  journal_.equal(Law::size, stratum.begin, raw_, "begin of a stratum");
  journal_.hold(Law::size, stratum.end > stratum.begin && stratum.end <= decision_.raw,
                "end of a stratum", static_cast<double>(stratum.end),
                static_cast<double>(decision_.raw));
  journal_.hold(Law::gamma, stratum.gamma >= 0 && stratum.gamma <= 1, "gamma of a stratum",
                stratum.gamma);
  journal_.equal(Law::size, stratum.is_last, stratum.end == decision_.raw, "the last stratum");
  is_planned_out_ = stratum.is_last;
  untold_ += stratum.end - stratum.begin;
  raw_ = stratum.end;
  return stratum;
}

// The package's events from the `first` on.
void Shadow::hold_content(EventSpan events, std::size_t first, Law law) {
  if (events.size() + first > kept_.size()) {
    return journal_.equal(Law::kept_set, events.size() + first, kept_.size(), "events kept");
  }
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Held& held = held_[kept_[first + i]];
    if (events[i] == held.event) continue;
    return journal_.equal(law, events[i].t, held.event.t, "stamp of an event of the package");
  }
}

void Shadow::part(const Package& package, EventSpan part, std::int64_t now_ns) {
  journal_.hold(Law::protocol, is_open_, "a part without a package");
  const std::size_t before = is_anytime_ ? kept_.size() : handed_out_;
  if (is_anytime_) {
    for (;;) {
      const AnytimePlan::Stratum stratum = next_stratum(now_ns);
      if (stratum.begin == stratum.end) break;
      if (stratum.is_last) {
        filter_.keep_exactly(head_ + stratum.begin, head_ + stratum.end, stratum.gamma, kept_);
      } else {
        filter_.keep(head_ + stratum.begin, head_ + stratum.end, stratum.gamma, kept_);
      }
      if (kept_.size() > handed_out_) break;
    }
  } else {
    handed_out_ = kept_.size();
  }
  const std::size_t wanted = kept_.size() - before;
  if (is_anytime_ && wanted > 0) hold_gamma(package, wanted);
  journal_.equal(Law::kept_set, part.size(), wanted, "events kept of a part");
  journal_.equal(Law::size, package.raw, raw_, "raw events so far");
  journal_.equal(Law::size, package.events.size(), kept_.size(), "events so far");
  if (!journal_.failed()) hold_content(part, before, Law::identity);
}

void Shadow::completing(const Package& package, std::int64_t end_ns) {
  journal_.hold(Law::protocol, is_open_, "a package that nobody decided is completed");
  const std::size_t size = package.events.size();
  journal_.hold(Law::size, size <= package.raw && package.raw <= setup_.capacity,
                "size of a package", static_cast<double>(size), static_cast<double>(package.raw));
  journal_.equal(Law::kept_set, size, kept_.size(), "events kept");
  // Nothing that has been pushed meanwhile lies where the package lies.
  hold_content(package.events, 0, Law::identity);
  for (const Event& event : package.events) {
    journal_.hold(Law::order, event.t >= last_t_, "stamp goes back", static_cast<double>(event.t),
                  static_cast<double>(last_t_));
    last_t_ = event.t;
  }
  const double gamma = static_cast<double>(size) / static_cast<double>(told_);
  if (size > 0) journal_.equal(Law::gamma, package.gamma, gamma, "gamma = size / told");
  end_ns_ = end_ns;
  is_completing_ = true;
}

void Shadow::told(const Outcome& outcome) noexcept {
  drop_stale();
  const std::int64_t processing_ns = is_completing_ ? end_ns_ - start_ns_ : 0;
  std::int64_t span_ns = 0;
  if (!kept_.empty()) {
    span_ns = axis_.to_ns(held_[kept_.back()].event.t) - axis_.to_ns(held_[kept_.front()].event.t);
  }
  journal_.hold(Law::protocol, is_open_, "told of a package that nobody decided");
  journal_.hold(Law::protocol, is_completing_ || kept_.empty(), "told before the end");
  journal_.equal(Law::size, outcome.size, kept_.size(), "size told");
  journal_.equal(Law::size, outcome.raw, raw_, "raw told");
  journal_.equal(Law::protocol, outcome.span_ns, span_ns, "span told");
  journal_.equal(Law::protocol, outcome.start_ns, start_ns_, "start told");
  journal_.equal(Law::protocol, outcome.processing_ns, processing_ns, "processing time told");
  if (journal_.failed() || !kept_.empty()) return;
  is_open_ = is_completing_ = false;
  discarded_ += raw_;
  offered_without_ += raw_;
  if (!is_anytime_) untold_ += raw_;
  leave(raw_);
}

void Shadow::completed(const RunLog& log) {
  if (!is_completing_ || journal_.failed()) return;  // nothing was kept
  is_open_ = is_completing_ = false;
  book_latencies(end_ns_);
  leave(raw_);
  delivered_ += kept_.size();
  discarded_ += raw_ - kept_.size();
  ++packages_;
  ++tally_.packages;
  journal_.equal(Law::protocol, log.size(), packages_, "rows of the log");
  if (!journal_.failed()) hold_row(log[log.size() - 1]);
  previous_start_ns_ = start_ns_;
  offered_without_ = 0;
  stale_since_ = 0;
  overflow_reported_ += overflow_before_;
}

void Shadow::hold_row(const PackageRow& row) {
  const auto same = [&](Law law, auto got, auto wanted, const char* what) {
    journal_.equal(law, static_cast<double>(got), static_cast<double>(wanted), what);
  };
  const Held& first = held_[kept_.front()];
  const std::size_t size = kept_.size();
  const std::int64_t processing_ns = end_ns_ - start_ns_;
  same(Law::protocol, row.index, packages_ - 1, "row: index");
  same(Law::protocol, row.processing_us, static_cast<double>(processing_ns) * 1e-3,
       "row: processing time");
  same(Law::order, row.t_first, first.event.t, "row: first stamp");
  same(Law::order, row.t_last, held_[kept_.back()].event.t, "row: last stamp");
  same(Law::ledger, row.offered, raw_ + offered_without_, "row: offered");
  same(Law::ledger, row.size, size, "row: size");
  same(Law::ledger, row.stale, stale_since_, "row: stale");
  same(Law::ledger, row.overflow, overflow_before_, "row: overflow");
  const double latency_ns = row.latency_max_us * 1e3;
  const auto oldest_ns = static_cast<double>(end_ns_ - first.time_ns);
  const double step = static_cast<double>(step_ns());
  const double rounding_ns = 1e-9 * std::abs(oldest_ns) + 1e-3;
  journal_.hold(
      Law::age,
      latency_ns >= oldest_ns - rounding_ns && latency_ns <= oldest_ns + step + rounding_ns,
      "row: largest latency", latency_ns, oldest_ns);
  if (setup_.by_arrival) {
    journal_.hold(Law::protocol, row.event_rate >= 0 && std::isfinite(row.event_rate),
                  "row: event rate", row.event_rate);
  } else {
    same(Law::protocol, row.event_rate, rate_.per_second(), "row: event rate");
  }
}

void Shadow::book_latencies(std::int64_t end_ns) {
  const std::int64_t bound_ns = setup_.latency_ns;
  const std::int64_t step = step_ns();
  for (const std::uint64_t index : kept_) {
    const Held& held = held_[index];
    const std::int64_t latency_ns = std::max<std::int64_t>(end_ns - held.time_ns, 0);
    ++latencies_.count;
    latencies_.within += latency_ns <= bound_ns ? 1U : 0U;
    latencies_.within_for_sure += latency_ns <= bound_ns - step ? 1U : 0U;
    latencies_.max_ns = std::max(latencies_.max_ns, latency_ns);
    latencies_.sum_ns += static_cast<double>(latency_ns);
    if (held.number < setup_.judged_from()) continue;
    if (tally_.judged_start_ns == kNever) {
      tally_.judged_start_ns = held.time_ns;
      tally_.judged_package = packages_;
    }
    ++tally_.judged_kept;
    tally_.judged_latency_ns = std::max(tally_.judged_latency_ns, latency_ns);
  }
  if (tally_.fingerprint == nullptr) return;
  Sha256& hash = *tally_.fingerprint;
  hash.feed(static_cast<std::uint64_t>(head_));
  hash.feed(static_cast<std::uint64_t>(raw_));
  hash.feed(static_cast<std::uint64_t>(start_ns_));
  hash.feed(static_cast<std::uint64_t>(kept_.size()));
  for (const std::uint64_t index : kept_) hash.feed(std::uint64_t{held_[index].number});
}

void Shadow::hold_ledger(const Ledger& ledger, const EventBuffer& buffer,
                         const Telemetry& telemetry) {
  journal_.hold(Law::ledger, ledger.balanced(), "received = sum of the others",
                static_cast<double>(ledger.received));
  journal_.equal(Law::ledger, ledger.overflow, overflow_, "overflow");
  journal_.equal(Law::ledger, ledger.stale, stale_, "stale");
  journal_.equal(Law::ledger, ledger.discarded, discarded_, "discarded");
  journal_.equal(Law::ledger, ledger.delivered, delivered_, "delivered");
  journal_.equal(Law::pending, buffer.size(), waiting(), "events in the ring");
  journal_.equal(Law::pending, buffer.tail(), held_.size(), "tail of the ring");
  journal_.equal(Law::pending, buffer.head(), head_, "head of the ring");
  journal_.hold(Law::pending, buffer.size() <= setup_.capacity, "pending <= capacity",
                static_cast<double>(buffer.size()), static_cast<double>(setup_.capacity));
  journal_.equal(Law::ledger, telemetry.latency.count(), delivered_, "latencies");
}

void Shadow::finish(const Telemetry& telemetry) {
  if (journal_.failed()) return;
  const LatencyHistogram& latency = telemetry.latency;
  const bool is_exact = step_ns() == 0;
  journal_.hold(Law::age, latency.max_ns() >= latencies_.max_ns, "largest latency",
                static_cast<double>(latency.max_ns()), static_cast<double>(latencies_.max_ns));
  journal_.hold(Law::age, latency.max_ns() - latencies_.max_ns <= step_ns(), "largest latency",
                static_cast<double>(latency.max_ns()), static_cast<double>(latencies_.max_ns));
  journal_.hold(Law::age,
                latency.within_bound() <= latencies_.within &&
                    latency.within_bound() >= latencies_.within_for_sure,
                "events within the bound", static_cast<double>(latency.within_bound()),
                static_cast<double>(latencies_.within));
  if (is_exact && latencies_.count > 0) {
    const double mean_ns = latencies_.sum_ns / static_cast<double>(latencies_.count);
    journal_.hold(Law::age, std::abs(latency.mean_ns() - mean_ns) <= 1e-6 * mean_ns + 1e-3,
                  "mean latency", latency.mean_ns(), mean_ns);
  }
}

}  // namespace asap::simulation
