#include "live_life.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace asap::simulation {
namespace {

constexpr std::int64_t kBootNs = 1'000'000'000'000;  // the machine has been up for a while
constexpr std::int64_t kPollNs = 20'000'000;         // of Pipeline::run
constexpr std::int64_t kAwayNs = 1'000'000;

// Thrown by the algorithm.
struct Broken {};

std::int64_t ns(System::Clock::time_point time) noexcept {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}

System::Clock::time_point at(std::int64_t time_ns) noexcept {
  return System::Clock::time_point(std::chrono::nanoseconds(time_ns));
}

}  // namespace

LiveLife::LiveLife(const Setup& setup, const LiveSetup& live, Scheme& scheme, World& world)
    : setup_(setup),
      live_(live),
      world_(world),
      journal_(world.journal),
      draw_(world.draw),
      own_loop_(live.own_loop && setup.execution == Execution::whole),
      own_scheme_(scheme),
      scheme_(scheme, *this),
      bound_ns_(setup.latency_ns),
      time_ns_(kBootNs),
      pipeline_(
          scheme_,
          run_config(setup,
                     live.passing < 1 ? FrontFilter([this](EventSpan events, std::span<Event> out) {
                       return filter(events, out);
                     })
                                      : FrontFilter{},
                     live.when_full)) {
  world_.over.resize(world.faults.size(), false);
  world_.tally.odd_package = kNoPackage;
  world_.tally.odd_packages = 0;
}

void LiveLife::run() {
  for (;;) {
    live_once();
    if (journal_.over() || world_.stream.ended() || draw_.chance(0.5)) return;
    in_world_ = true;
    pipeline_.start();
    in_world_ = false;
  }
}

void LiveLife::live_once() {
  door_.emplace(setup_.door);
  shadow_.emplace(setup_, live_, bound_ns_, journal_, world_.tally);
  is_stopped_ = false;
  ask_ns_ = kNever;
  offset_ns_ = kNever;
  read_packet();
  if (draw_.chance(0.3)) run_until(time_ns_ + draw_.between(0, 8 * bound_ns_));  // comes late
  bool has_thrown = false;
  shadow_->enters(own_loop_ ? live_.patience_ns : kPollNs);
  try {
    if (own_loop_) {
      loop();
    } else {
      pipeline_.run([this](const Package& package) { work(package); },
                    [this] { shadow_->enters(kPollNs); });
    }
  } catch (const Broken&) {
    has_thrown = true;
    in_world_ = journal_.over();
  }
  world_.tally.received += door_->received;
  if (journal_.over()) return;
  if (has_thrown) {
    shadow_->closes();
  } else {
    shadow_->ended();
  }
  hold_now();
  in_world_ = true;  // this look at the clock is not the consumer's
  shadow_->finish(pipeline_.stats().latency);
  in_world_ = false;
}

// ---- machine

// Others may act before the consumer comes to use what it has read.
LiveLife::Time LiveLife::now() noexcept {
  if (in_world_) return at(time_ns_);
  if (journal_.over()) give_up();
  shadow_->looks();
  const std::int64_t before_ns = time_ns_;
  run_until(time_ns_ + world_.lag_ns());
  const std::int64_t now_ns = draw_.chance(0.5) ? before_ns : time_ns_;
  shadow_->saw(now_ns);
  return at(now_ns);
}

void LiveLife::sleep(System::Word& word, Time deadline) noexcept {
  if (word != 1) return;
  std::int64_t until_ns = ns(deadline);
  journal_.step("sleep", time_ns_, shadow_->waiting());
  shadow_->sleeps(until_ns);
  const bool is_early = draw_.chance(0.01);
  if (is_early) until_ns = std::min(until_ns, time_ns_ + draw_.between(0, bound_ns_));
  while (!journal_.over() && word == 1 && next_ns() <= until_ns) {
    if (next_ns() == kNever) {
      journal_.hold(Law::liveness, false, "the consumer sleeps for ever");
      break;
    }
    act();
  }
  // The kernel looks at its queue, not at the word.
  if (word == 1) time_ns_ = std::max(time_ns_, until_ns);
  shadow_->wakes_up();
  if (journal_.over()) return give_up();
  run_until(time_ns_ + world_.lag_ns());
}

void LiveLife::wake(System::Word& word) noexcept {
  journal_.hold(Law::protocol, word != 1, "wakes before the word is changed");
  shadow_->woken();
}

// ---- the scheme's words

void LiveLife::asked(const Backlog& backlog) noexcept { shadow_->asked(backlog); }

void LiveLife::decided(const Backlog& backlog, const Decision& decision) noexcept {
  if (journal_.over()) return;
  shadow_->decided(backlog, decision, belief(setup_, own_scheme_));
}

void LiveLife::told(const Outcome& outcome) noexcept {
  if (journal_.over()) return;
  shadow_->told(outcome);
}

// ---- world

void LiveLife::run_until(std::int64_t time_ns) {
  while (!journal_.over() && next_ns() <= time_ns) act();
  time_ns_ = std::max(time_ns_, time_ns);
}

void LiveLife::act() {
  in_world_ = true;
  time_ns_ = std::max(time_ns_, next_ns());
  if (ask_ns_ <= packet_ns_) {
    ask();
  } else {
    produce();
  }
  if (!journal_.over()) {
    shadow_->hold_wake();
    hold_now();
  }
  in_world_ = false;
}

void LiveLife::hold_now() {
  const bool was_inside = in_world_;
  in_world_ = true;
  shadow_->hold_ledger(pipeline_.ledger());
  journal_.equal(Law::ledger, pipeline_.ledger().received, door_->received, "received");
  journal_.equal(Law::ledger, pipeline_.ledger().rejected, door_->rejected.total(), "rejected");
  in_world_ = was_inside;
}

void LiveLife::read_packet() {
  world_.stream.read(packet_);
  if (offset_ns_ == kNever) offset_ns_ = time_ns_ - packet_.sent_ns + draw_.between(0, bound_ns_);
  packet_ns_ = packet_.sent_ns + offset_ns_;
}

void LiveLife::produce() {
  const bool is_calm = world_.stream.position() >= setup_.faults_end();
  if (world_.happens(FaultKind::stop)) {
    stop(draw_.chance(0.5));
  } else if (world_.happens(FaultKind::restart) || world_.happens(FaultKind::reconfigure)) {
    stop(true);
  } else if (!is_calm && world_.stream.position() >= live_.abandoned_at) {
    stop(false);
  } else {
    push();
    if (world_.stream.ended()) return stop(true);
    read_packet();
    if (ask_ns_ == kNever && draw_.chance(live_.asks)) {
      ask_ns_ = time_ns_ + draw_.between(0, (draw_.chance(0.8) ? 1 : 16) * bound_ns_);
    }
  }
}

void LiveLife::push() {
  good_.clear();
  numbers_.clear();
  const std::uint64_t resets = door_->resets;
  bool refused = false;
  for (std::size_t i = 0; i < packet_.events.size() && !refused; ++i) {
    Event event = packet_.events[i];
    refused = !door_->passes_live(event, EventSpan(packet_.events).subspan(i + 1));
    if (!refused) {
      good_.push_back(event);
      numbers_.push_back(packet_.numbers[i]);
    }
    refused = refused && setup_.door.on_bad == OnBad::raise;
  }
  std::int64_t said_ns = time_ns_;
  if (world_.stream.position() < setup_.faults_end() && draw_.chance(0.1)) {
    said_ns += draw_.between(-bound_ns_ / 4, bound_ns_ / 4);
  }
  const std::int64_t came_ns = std::min(said_ns, time_ns_);
  if (!good_.empty() && !shadow_->has_begun()) shadow_->begins(good_.front(), came_ns, time_ns_);
  journal_.step("push", time_ns_, good_.size(), shadow_->waiting());
  const Ledger before = pipeline_.ledger();
  bool threw = false;
  bool taken = true;
  try {
    taken = said_ns == time_ns_ ? pipeline_.push(packet_.events)
                                : pipeline_.push(packet_.events, at(said_ns));
  } catch (const std::invalid_argument&) {
    threw = true;
  }
  journal_.hold(Law::protocol, taken, "an open door is shut");
  journal_.equal(Law::protocol, threw, refused, "the door refuses");
  shadow_->pushed({good_, numbers_, came_ns, door_->resets != resets}, before, pipeline_.ledger());
}

// What any other thread may do meanwhile.
void LiveLife::ask() {
  ask_ns_ = kNever;
  const std::size_t what = draw_.below(is_stopped_ ? 2 : 4);
  if (what == 0) {
    const PipelineStats stats = pipeline_.stats();
    shadow_->hold_stalled(stats.stalled, time_ns_);
    journal_.equal(Law::protocol, stats.clock_resets, door_->resets, "clock resets");
    journal_.equal(Law::protocol, stats.latency_bound_ns, bound_ns_, "bound of the snapshot");
  } else if (what == 1 && is_stopped_) {
    stop(draw_.chance(0.5));
  } else if (what == 3 && world_.stream.position() < setup_.faults_end()) {
    bound_ns_ = 1000 * std::max<std::int64_t>(
                           10, static_cast<std::int64_t>(static_cast<double>(setup_.latency_ns) *
                                                         1e-3 * draw_.octaves(0.25, 4)));
    journal_.step("bound", time_ns_, static_cast<std::uint64_t>(bound_ns_));
    pipeline_.set_latency(std::chrono::nanoseconds(bound_ns_));
    shadow_->sets_bound(bound_ns_);
  } else {
    journal_.step("flush", time_ns_, shadow_->waiting());
    pipeline_.flush();
    shadow_->flushes();
  }
}

void LiveLife::stop(bool drain) {
  journal_.step("stop", time_ns_, drain ? 1 : 0, shadow_->waiting());
  pipeline_.stop(drain);
  is_stopped_ = true;
  packet_ns_ = kNever;
  shadow_->closes();
  if (!drain) shadow_->abandons();
  journal_.hold(Law::protocol, !pipeline_.push(packet_.events), "a shut door is open");
  if (ask_ns_ == kNever && draw_.chance(0.5)) ask_ns_ = time_ns_ + draw_.between(0, bound_ns_);
}

// A check has failed, or the step asked for is reached: the consumer is to come out.
void LiveLife::give_up() noexcept {
  if (has_given_up_) return;
  has_given_up_ = in_world_ = true;
  pipeline_.stop(false);
  in_world_ = false;
}

// ---- consumer

void LiveLife::loop() {
  Package package;
  for (;;) {
    const auto next = pipeline_.next(package, std::chrono::nanoseconds(live_.patience_ns));
    if (next == Pipeline::Next::ended) return;
    if (next == Pipeline::Next::package) {
      work(package);
      if (draw_.chance(0.5)) pipeline_.complete();
    } else {
      shadow_->idles();
      if (live_.patience_ns == 0) run_until(time_ns_ + std::max(bound_ns_ / 4, kAwayNs));
      shadow_->enters(live_.patience_ns);
    }
    if (journal_.over()) return give_up();
  }
}

void LiveLife::work(const Package& package) {
  if (journal_.over()) fail();
  ConsumerCost& cost = world_.cost;
  const std::size_t position = world_.stream.position();
  journal_.step(package.continues ? "part" : "package", time_ns_, package.raw,
                package.events.size());
  shadow_->part(package, position);
  shadow_->works();
  std::int64_t cost_ns = world_.lag_ns();
  if (!package.continues) {
    cost.begin(position);
    if (cost.is_odd()) {
      world_.tally.odd_package = shadow_->packages();
      ++world_.tally.odd_packages;
    }
    cost_ns += cost.stall_ns(position) + cost.fixed_ns();
  }
  run_until(time_ns_ + cost_ns + cost.of_ns(package.events.size()));
  if (own_loop_) return;
  if (world_.happens(FaultKind::gone)) {  // until somebody stops the pipeline
    while (!journal_.over() && next_ns() != kNever) act();
    fail();
  }
  if (world_.happens(FaultKind::exception)) fail();
}

// Until the pipeline has stopped itself others wait for its lock.
void LiveLife::fail() {
  journal_.step("exception", time_ns_);
  in_world_ = true;
  throw Broken{};
}

std::size_t LiveLife::filter(EventSpan events, std::span<Event> out) {
  std::size_t passed = 0;
  for (const Event& event : events) {
    if (live_.passes(event)) out[passed++] = event;
  }
  if (!journal_.over()) shadow_->filters(events, passed);
  return passed;
}

}  // namespace asap::simulation
