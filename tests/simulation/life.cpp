#include "life.hpp"

#include <algorithm>
#include <stdexcept>

#include "packager/event_times.hpp"

namespace asap::simulation {
namespace {

constexpr std::size_t kLogRows = RunLog::kBlockRows;
constexpr std::int64_t kEndOfTimeNs = 9'150'000'000'000'000'000;  // beyond any stamp

std::int64_t share_ns(std::int64_t latency_ns, std::int64_t parts) {
  return std::max<std::int64_t>(latency_ns / parts, 1);
}

}  // namespace

Life::Life(const Setup& setup, Scheme& scheme, World& world)
    : setup_(setup),
      world_(world),
      journal_(world.journal),
      draw_(world.draw),
      shadow_(setup, world.journal, world.tally),
      reference_door_(setup.door),
      scheme_(scheme, *this),
      door_(setup.door),
      telemetry_(setup.latency_ns, setup.by_arrival ? kLogRows : RunLog::kAllRows),
      buffer_(setup.capacity),
      ages_(share_ns(setup.latency_ns, 64)),
      arrivals_(share_ns(setup.latency_ns, 1024)),
      packager_(buffer_, setup.by_arrival ? EventTimes(arrivals_) : EventTimes(ages_), scheme_,
                telemetry_,
                {.seed = setup.filter_seed, .execution = setup.execution, .flush = setup.flush}),
      looks_first_(world.draw.chance(0.5)) {
  world_.over.resize(world.faults.size(), false);
  world_.tally.calm_ns = world_.tally.judged_start_ns = kNever;  // another clock
  world_.tally.odd_package = kNoPackage;
  world_.tally.odd_packages = 0;
}

void Life::run() {
  while (!journal_.over() && doing_ != Doing::ended) {
    if (stop_wanted_ && source_ != Source::closed) {
      close();
    } else if (source_ != Source::closed && (producer_ns_ < consumer_ns_ ||
                                             (producer_ns_ == consumer_ns_ && draw_.chance(0.5)))) {
      produce();
    } else if (consumer_ns_ != kNever) {
      consume();
    } else {
      // A consumer that never returns is given up; one that sleeps has missed the end.
      journal_.hold(Law::liveness, doing_ == Doing::gone, "the consumer sleeps for ever");
      doing_ = Doing::ended;
      abandoned_ = true;
    }
    hold_between_steps();
  }
  world_.tally.received += door_.received();
  if (journal_.over()) return;
  journal_.hold(Law::liveness, abandoned_ || buffer_.size() == 0, "events wait after the end",
                static_cast<double>(buffer_.size()), 0);
  shadow_.finish(telemetry_);
}

// ---- faults

std::int64_t Life::clock_ns() noexcept {
  return consumer_ns_ - world_.cost.step_back_ns(world_.stream.position());
}

// ---- producer

void Life::produce() {
  in_producer_ = true;
  if (world_.happens(FaultKind::stop)) {
    stop(draw_.chance(0.5));
    if (draw_.chance(0.5)) stop(draw_.chance(0.5));
  } else if (world_.happens(FaultKind::restart) || world_.happens(FaultKind::reconfigure)) {
    stop(true);
  } else if (sent_ < outbox_.size()) {
    push_arrived();
  } else if (world_.stream.ended()) {
    stop(true);
  } else {
    read_packet();
  }
  in_producer_ = false;
}

void Life::read_packet() {
  world_.stream.read(packet_);
  journal_.step("packet", producer_ns_, packet_.events.size(), world_.stream.position());
  if (setup_.by_arrival) producer_ns_ = std::max(producer_ns_, packet_.sent_ns + offset_ns_);
  good_.clear();
  numbers_.clear();
  outbox_.clear();
  outbox_numbers_.clear();
  taken_in_ = sent_ = 0;
  bool refused = false;
  for (std::size_t i = 0; i < packet_.events.size() && !refused; ++i) {
    Event event = packet_.events[i];
    if (reference_door_.passes(event)) {
      good_.push_back(event);
      numbers_.push_back(packet_.numbers[i]);
    } else {
      if (packet_.numbers[i] >= setup_.judged_from()) ++world_.tally.judged_rejected;
      refused = setup_.door.on_bad == OnBad::raise;
    }
  }
  // The arrival is what the producer says; never in the future, never before the last.
  const std::int64_t said_ns = producer_ns_ - (draw_.chance(0.9) ? 0 : world_.lag_ns());
  arrival_ns_ = has_begun_ ? std::max(arrival_ns_, said_ns) : said_ns;
  bool threw = false;
  try {
    door_.check(packet_.events, [this](EventSpan good) { take_in(good); });
  } catch (const std::invalid_argument&) {
    threw = true;
  }
  journal_.equal(Law::protocol, threw, refused, "the door refuses");
  journal_.equal(Law::identity, taken_in_, good_.size(), "events that pass the door");
  journal_.equal(Law::ledger, door_.received(), reference_door_.received, "received");
  journal_.hold(Law::ledger, door_.rejected() == reference_door_.rejected, "rejected by reason",
                static_cast<double>(door_.rejected().total()),
                static_cast<double>(reference_door_.rejected.total()));
  journal_.equal(Law::protocol, door_.clock_resets(), reference_door_.resets, "clock resets");
  if (setup_.by_arrival) producer_ns_ += world_.lag_ns();
}

// In the middle of the door's check: a run of good events.
void Life::take_in(EventSpan good) {
  if (taken_in_ + good.size() > good_.size()) {
    return journal_.equal(Law::identity, taken_in_ + good.size(), good_.size(), "events too many");
  }
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (good[i] == good_[taken_in_ + i]) continue;
    return journal_.equal(Law::identity, good[i].t, good_[taken_in_ + i].t,
                          "event behind the door");
  }
  if (!has_begun_) begin(good.front());
  const std::uint32_t* const numbers = numbers_.data() + taken_in_;
  taken_in_ += good.size();
  if (setup_.by_arrival) return push(good, numbers);
  outbox_.insert(outbox_.end(), good.begin(), good.end());
  outbox_numbers_.insert(outbox_numbers_.end(), numbers, numbers + good.size());
  producer_ns_ = std::max(producer_ns_, axis_.to_ns(outbox_.front().t));
}

void Life::begin(const Event& first) {
  has_begun_ = true;
  axis_ = TimeAxis(first.t, 1.0);
  packager_.begin(axis_, 0);
  shadow_.set_axis(axis_);
  offset_ns_ = axis_.to_ns(first.t) - packet_.sent_ns;
  producer_ns_ = arrival_ns_ = axis_.to_ns(first.t);
}

void Life::push(EventSpan events, const std::uint32_t* numbers) {
  const std::int64_t until_ns = producer_ns_ + world_.lag_ns();
  const std::uint64_t first = buffer_.tail();
  if (setup_.by_arrival) {
    let_consumer(until_ns);
    arrivals_.note(first, arrival_ns_);
  }
  let_consumer(until_ns);
  journal_.step("push", producer_ns_, events.size(), buffer_.tail());
  const std::size_t wanted = shadow_.pushed(events, numbers, arrival_ns_);
  const std::size_t taken = buffer_.push(events);
  journal_.equal(Law::ledger, taken, wanted, "events that fit");
  let_consumer(until_ns);
  if (!setup_.by_arrival) {
    ages_.observe(events.first(taken), first,
                  [this](std::int64_t stamp) { return axis_.to_ns(stamp); });
    shadow_.observed_ages();
  }
  if (buffer_.tail() >= wanted_tail_) wake(producer_ns_ + world_.lag_ns());
  if (draw_.chance(0.002)) {  // ConsumerLoop::flush, from any thread
    flush_wanted_ = buffer_.tail();
    wake(producer_ns_);
  }
}

// By stamp: some of the events whose time has come.
void Life::push_arrived() {
  std::size_t end = sent_ + 1 + draw_.below(outbox_.size() - sent_);
  const std::int64_t limit_ns = producer_ns_ + setup_.latency_ns / 64;
  while (end > sent_ + 1 && axis_.to_ns(outbox_[end - 1].t) > limit_ns) --end;
  producer_ns_ = std::max(producer_ns_, axis_.to_ns(outbox_[end - 1].t));
  const std::size_t begin = sent_;
  sent_ = end;
  push(EventSpan(outbox_).subspan(begin, end - begin), outbox_numbers_.data() + begin);
  producer_ns_ += world_.lag_ns();
  if (sent_ < outbox_.size()) {
    producer_ns_ = std::max(producer_ns_, axis_.to_ns(outbox_[sent_].t));
  }
}

// The door is shut once no producer is inside; what has not arrived stays with the source.
void Life::close() {
  journal_.step("close", producer_ns_, drains_ ? 1 : 0, buffer_.tail());
  buffer_.close();
  shadow_.closed();
  source_ = Source::closed;
  if (!drains_) abandoned_ = true;
  wake(producer_ns_);
}

void Life::stop(bool drain) noexcept {
  drains_ = stop_wanted_ ? drains_ && drain : drain;
  stop_wanted_ = true;
  if (source_ == Source::closed && !drains_) {
    abandoned_ = true;
    wake(producer_ns_);
  }
}

void Life::let_producer(std::int64_t until_ns) {
  while (!in_producer_ && source_ != Source::closed && !stop_wanted_ && producer_ns_ <= until_ns &&
         !journal_.over() && draw_.chance(0.7)) {
    produce();
  }
}

// ---- consumer

void Life::consume() {
  in_consumer_ = true;
  if (doing_ == Doing::sleeps) {
    ask();
  } else {
    go_on();
  }
  in_consumer_ = false;
}

void Life::let_consumer(std::int64_t until_ns) {
  while (!in_consumer_ && consumer_ns_ <= until_ns && !journal_.over() && draw_.chance(0.7) &&
         doing_ != Doing::ended) {
    consume();
  }
}

void Life::ask() {
  journal_.step("ask", consumer_ns_, buffer_.size(), buffer_.head());
  if (abandoned_) {
    doing_ = Doing::ended;
    consumer_ns_ = kNever;
    return;
  }
  const bool is_closed = buffer_.closed();  // before the look at the ring
  packager_.flush(flush_wanted_);
  shadow_.flush(flush_wanted_);
  if (buffer_.size() == 0 && (looks_first_ || !has_begun_)) {
    if (!is_closed) return sleep(buffer_.head() + 1, kNever);
    doing_ = Doing::ended;
    consumer_ns_ = kNever;
    return;
  }
  const std::int64_t now_ns = clock_ns();
  const std::int64_t begun_ns = consumer_ns_;
  let_producer(begun_ns + world_.lag_ns());
  telemetry_.log.make_room();
  shadow_.asking(now_ns);
  const Packager::Next next = packager_.next(now_ns);
  shadow_.answered(next, buffer_);
  if (next.step == Packager::Step::ended) {
    doing_ = Doing::ended;
    consumer_ns_ = kNever;
  } else if (next.step == Packager::Step::wait) {
    sleep(next.until_tail, next.until_ns);
  } else {
    package_ = next.package;
    begin_package();
  }
}

void Life::sleep(std::uint64_t tail, std::int64_t until_ns) noexcept {
  const std::int64_t now_ns = consumer_ns_;
  doing_ = Doing::sleeps;
  wanted_tail_ = tail;
  consumer_ns_ =
      until_ns > kEndOfTimeNs ? kNever : std::max(until_ns, now_ns + 1) + world_.lag_ns();
  // What has happened between the question and the sleep; and sometimes without a reason.
  const bool is_there = buffer_.tail() >= tail || buffer_.closed() || abandoned_;
  if (is_there || draw_.chance(0.01)) wake(now_ns + 1 + world_.lag_ns());
}

void Life::wake(std::int64_t time_ns) noexcept {
  if (doing_ == Doing::sleeps) consumer_ns_ = std::min(consumer_ns_, time_ns);
}

void Life::begin_package() {
  const std::size_t position = world_.stream.position();
  world_.cost.begin(position);
  if (world_.cost.is_odd()) {
    world_.tally.odd_package = shadow_.packages();
    ++world_.tally.odd_packages;
  }
  doing_ = Doing::works;
  journal_.step("package", consumer_ns_, package_.raw, package_.events.size());
  consumer_ns_ += world_.cost.stall_ns(position);
  const bool is_anytime = package_.events.empty();
  if (is_anytime && !setup_.fixed_cost_first) return;
  if (!is_anytime && setup_.asks_stratum) {
    const EventSpan all = packager_.stratum(package_, consumer_ns_);
    shadow_.part(package_, all, consumer_ns_);
  }
  consumer_ns_ += world_.cost.fixed_ns() + world_.lag_ns();
  if (!is_anytime) consumer_ns_ += world_.cost.of_ns(package_.events.size());
}

// The part before is done: the next one, or the end.
void Life::go_on() {
  const std::int64_t now_ns = clock_ns();
  if (package_.events.size() > 0) {  // the algorithm has been at work
    if (world_.happens(FaultKind::gone)) {
      journal_.step("gone", now_ns);
      doing_ = Doing::gone;
      consumer_ns_ = kNever;
      if (draw_.chance(0.5)) stop(draw_.chance(0.5));
      return;
    }
    if (world_.happens(FaultKind::exception)) {  // out of Pipeline::run
      journal_.step("exception", now_ns);
      stop(false);
      doing_ = Doing::gone;
      consumer_ns_ = kNever;
      return;
    }
    if (world_.happens(FaultKind::stop)) stop(draw_.chance(0.5));
  }
  const bool is_whole = !package_.events.empty() && package_.raw > 0 && !setup_.asks_stratum;
  if (is_whole && setup_.execution == Execution::whole) return complete(now_ns);
  const bool is_first = package_.events.empty();
  let_producer(consumer_ns_ + world_.lag_ns());
  const EventSpan part = packager_.stratum(package_, now_ns);
  shadow_.part(package_, part, now_ns);
  if (part.empty()) return complete(now_ns);
  journal_.step("part", now_ns, package_.raw, package_.events.size());
  consumer_ns_ += world_.cost.of_ns(part.size()) + world_.lag_ns();
  if (is_first && !setup_.fixed_cost_first) consumer_ns_ += world_.cost.fixed_ns();
}

void Life::complete(std::int64_t end_ns) {
  journal_.step("complete", end_ns, package_.raw, package_.events.size());
  let_producer(consumer_ns_ + world_.lag_ns());
  shadow_.completing(package_, end_ns);
  packager_.complete(package_, end_ns);
  shadow_.completed(telemetry_.log);
  doing_ = Doing::sleeps;
  consumer_ns_ += world_.lag_ns();
  Tally& tally = world_.tally;
  const std::int64_t usual_ns = std::max(setup_.latency_ns, setup_.scheme.period_ns);
  const bool has_caught_up = setup_.keeps_a_bound() || shadow_.longest_wait_ns(end_ns) <= usual_ns;
  const bool is_over = world_.stream.position() >= setup_.faults_end();
  if (tally.calm_ns == kNever && is_over && has_caught_up) {
    tally.calm_ns = consumer_ns_;
    tally.calm_package = shadow_.packages();
  }
}

// ---- the scheme's words

void Life::asked(const Backlog& backlog) noexcept { shadow_.asked(backlog, draw_.bits()); }

void Life::decided(const Backlog& backlog, const Decision& decision) noexcept {
  shadow_.decided(backlog, decision);
  let_producer(consumer_ns_ + world_.lag_ns());
}

void Life::told(const Outcome& outcome) noexcept { shadow_.told(outcome); }

// ---- checks

Ledger Life::ledger() const noexcept {
  return {.received = door_.received(),
          .rejected = door_.rejected().total(),
          .discarded = telemetry_.discarded,
          .stale = telemetry_.stale,
          .overflow = buffer_.overflow(),
          .delivered = telemetry_.delivered,
          .pending = buffer_.size() + (outbox_.size() - sent_)};
}

void Life::hold_between_steps() {
  if (!journal_.over()) shadow_.hold_ledger(ledger(), buffer_, telemetry_);
}

}  // namespace asap::simulation
