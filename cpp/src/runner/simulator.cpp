#include "asap/runner/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/check.hpp"
#include "core/made.hpp"
#include "runner/run.hpp"
#include "schemes/scheme_hold.hpp"
#include "telemetry/slot_log.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::uint64_t kNoTail = std::numeric_limits<std::uint64_t>::max();

}  // namespace

class Simulator::Impl {
 public:
  Impl(Scheme& scheme, SimulatedCost cost, const RunConfig& config, Consumer consumer,
       double speed);

  void feed(EventSpan events);
  void finish();
  void run(EventSource& source);
  Ledger ledger() const noexcept { return run_.ledger(outside()); }
  RunStats stats() const {
    RunStats stats;
    run_.copy_stats_to(stats, outside());
    stats.gap_us = std::llround(static_cast<double>(run_.gap_us()) / speed_);
    return stats;
  }
  const Run& parts() const noexcept { return run_; }
  std::span<const Slot> slots() const noexcept { return slots_.slots(); }
  std::int64_t busy_ns() const noexcept { return busy_ns_; }

 private:
  // What may end the run by an exception.
  template <class Work>
  void guard(const Work& work);
  Run::Outside outside() const noexcept { return {.is_quiet = true, .waiting = arriving_.size()}; }
  void receive(EventSpan good);
  void drain();
  void start(const Event& first);
  void run_while_known();
  // Pass time until this part of the package is done, or the wait is over; false: the known
  // arrivals end before that. Meanwhile events arrive, and the package still holds its place in the
  // ring.
  bool work();
  bool wait(const Packager::Next& next);
  void begin(const Package& package);
  void go_on();  // with the next part of the package, or complete it
  // What so many more events of the package in work take, after the `worked_` ones: ns.
  double work_ns(std::size_t more);
  double function_ns(std::size_t n) const;
  void admit(std::size_t count);
  std::size_t arrivals_by(std::int64_t time_ns) const noexcept;

  const LinearCost cost_;  // of a function: no outages, and nothing else
  const CostFunction function_;
  const Consumer consumer_;
  const double speed_;
  SchemeHold hold_;  // from the first event to the end of the run
  Run run_;
  SlotLog slots_;

  EventSpan arriving_;  // of the chunk being fed: events that have not arrived yet
  bool started_ = false;
  std::int64_t now_ns_ = kLongAgo;
  bool is_working_ = false;
  Package working_{};           // the package in work, if is_working_
  PackageCost working_cost_{};  // of a LinearCost
  std::size_t worked_ = 0;      // of a CostFunction: events, by the end of the part in work,
  double worked_ns_ = 0;        // and what they take
  std::uint64_t begun_ = 0;     // packages: each has a draw of its own
  std::int64_t busy_until_ns_ = kLongAgo;
  std::int64_t busy_ns_ = 0;
  bool is_waiting_ = false;
  Packager::Next waiting_{};  // the wait in force, if is_waiting_
};

Simulator::Impl::Impl(Scheme& scheme, SimulatedCost cost, const RunConfig& config,
                      Consumer consumer, double speed)
    : cost_(std::holds_alternative<LinearCost>(cost) ? std::get<LinearCost>(cost) : LinearCost()),
      function_(std::holds_alternative<LinearCost>(cost) ? CostFunction()
                                                         : std::get<CostFunction>(cost)),
      consumer_(std::move(consumer)),
      speed_(speed),
      hold_(scheme),
      run_(scheme, config, Run::Source::recording) {
  hold_.release();
  if (std::holds_alternative<CostFunction>(cost) && !function_) {
    throw_bad_value("cost", "none", "give the us that n events take");
  }
  require(speed >= 1e-3 && speed <= 1e6, "speed", speed, "must be between 0.001 and 1e6");
}

template <class Work>
void Simulator::Impl::guard(const Work& work) {
  hold_.take();
  try {
    run_.guard(work);
  } catch (...) {
    hold_.release();
    throw;
  }
}

void Simulator::Impl::feed(EventSpan events) {
  guard([&] { run_.validator().check(events, [this](EventSpan good) { receive(good); }); });
}

void Simulator::Impl::run(EventSource& source) {
  guard([&] {
    for (EventSpan chunk = source.next(); !chunk.empty(); chunk = source.next()) feed(chunk);
    finish();
  });
}

void Simulator::Impl::finish() {
  guard([this] { drain(); });
  hold_.release();
}

void Simulator::Impl::drain() {
  run_.buffer().close();
  for (;;) {
    while (is_working_) {
      now_ns_ = busy_until_ns_;
      go_on();
    }
    now_ns_ = cost_.start_ns(now_ns_);
    run_.telemetry().log.make_room();
    const Packager::Next next = run_.packager().next(now_ns_);
    if (next.step != Packager::Step::package) return;  // a closed source is never waited for
    begin(next.package);
  }
}

void Simulator::Impl::receive(EventSpan good) {
  if (good.empty()) return;
  if (!started_) start(good.front());
  slots_.received(good);
  arriving_ = good;
  run_while_known();
}

void Simulator::Impl::start(const Event& first) {
  run_.begin(first.t, speed_);
  now_ns_ = run_.axis().to_ns(first.t);
  started_ = true;
}

void Simulator::Impl::run_while_known() {
  for (;;) {
    if (is_working_ && !work()) return;
    if (is_working_) continue;
    if (is_waiting_ && !wait(waiting_)) return;
    admit(arrivals_by(now_ns_));
    if (arriving_.empty()) return;  // the next chunk may hold more for this moment
    const std::int64_t free_ns = cost_.start_ns(now_ns_);
    if (free_ns > now_ns_) {
      waiting_ = {.step = Packager::Step::wait, .until_ns = free_ns, .until_tail = kNoTail};
      is_waiting_ = true;
      continue;
    }
    run_.telemetry().log.make_room();
    const Packager::Next next = run_.packager().next(now_ns_);
    if (next.step == Packager::Step::package) {
      begin(next.package);
    } else {
      waiting_ = next;
      is_waiting_ = true;
    }
  }
}

bool Simulator::Impl::work() {
  admit(arrivals_by(busy_until_ns_));
  if (arriving_.empty()) return false;  // the next chunk may hold more for this time
  now_ns_ = busy_until_ns_;
  go_on();
  return true;
}

bool Simulator::Impl::wait(const Packager::Next& next) {
  const std::uint64_t missing = next.until_tail - run_.buffer().tail();
  const std::size_t known = std::min<std::uint64_t>(missing, arriving_.size());
  const std::int64_t last_ns = known > 0 ? run_.axis().to_ns(arriving_[known - 1].t) : kLongAgo;
  if (known < missing && last_ns <= next.until_ns) {
    now_ns_ = std::max(now_ns_, last_ns);
    admit(known);
    return false;
  }
  now_ns_ = known == missing ? std::min(last_ns, next.until_ns) : next.until_ns;
  is_waiting_ = false;
  return true;
}

void Simulator::Impl::begin(const Package& package) {
  working_ = package;
  is_working_ = true;
  working_cost_ = cost_.package(begun_++, package.start_ns);
  // An anytime package shows its events later, stratum by stratum.
  const bool is_whole = !package.events.empty();
  const std::size_t size = is_whole ? run_.packager().stratum(working_, now_ns_).size() : 0;
  worked_ = 0;
  worked_ns_ = 0;
  busy_until_ns_ = cost_.done_ns(now_ns_, function_ ? work_ns(size) : working_cost_.of(size));
}

double Simulator::Impl::work_ns(std::size_t more) {
  if (!function_) return working_cost_.event_ns * static_cast<double>(more);
  worked_ += more;
  const double until_ns = std::max(function_ns(worked_), worked_ns_);  // what is done stays done
  return until_ns - std::exchange(worked_ns_, until_ns);
}

double Simulator::Impl::function_ns(std::size_t n) const {
  const double t_us = run_.axis().to_us(working_.start_ns);
  const double cost_us = function_(n, t_us);
  if (!(cost_us >= 0 && std::isfinite(cost_us))) {
    throw_bad_value("cost(" + std::to_string(n) + ", " + std::to_string(std::llround(t_us)) + ")",
                    to_text(cost_us),
                    "give the us that n events take, from t_us on: finite and not negative");
  }
  return 1e3 * cost_us;
}

void Simulator::Impl::go_on() {
  const EventSpan part = run_.packager().stratum(working_, now_ns_);
  if (!part.empty()) {
    busy_until_ns_ = cost_.done_ns(now_ns_, work_ns(part.size()));
    return;
  }
  is_working_ = false;
  if (consumer_ && !working_.events.empty()) consumer_(working_);
  slots_.delivered(working_.events, now_ns_, run_.axis());
  busy_ns_ += now_ns_ - working_.start_ns;
  run_.packager().complete(working_, now_ns_);
}

void Simulator::Impl::admit(std::size_t count) {
  if (count == 0) return;
  run_.arrive(arriving_.first(count));
  arriving_ = arriving_.subspan(count);
}

std::size_t Simulator::Impl::arrivals_by(std::int64_t time_ns) const noexcept {
  const auto arrived = [&](const Event& event) { return run_.axis().to_ns(event.t) <= time_ns; };
  // Gallop first: the answer is mostly near the front of a long chunk.
  std::size_t known = 0;
  std::size_t ahead = 1;
  while (ahead <= arriving_.size() && arrived(arriving_[ahead - 1])) {
    known = ahead;
    ahead *= 2;
  }
  const EventSpan rest = arriving_.subspan(known, std::min(ahead - 1, arriving_.size()) - known);
  const auto end = std::partition_point(rest.begin(), rest.end(), arrived);
  return known + static_cast<std::size_t>(end - rest.begin());
}

Simulator::Simulator(Scheme& scheme, SimulatedCost cost, RunConfig config, Consumer consumer,
                     double speed)
    : impl_(std::make_unique<Impl>(scheme, std::move(cost), config, std::move(consumer), speed)) {}

Simulator::~Simulator() = default;

void Simulator::feed(EventSpan events) { impl_->feed(events); }
void Simulator::run(EventSource& source) { impl_->run(source); }

void Simulator::finish() { impl_->finish(); }
Ledger Simulator::ledger() const noexcept { return impl_->ledger(); }
const Validator& Simulator::validator() const noexcept { return impl_->parts().validator(); }
RunStats Simulator::stats() const { return impl_->stats(); }
const RunLog& Simulator::log() const noexcept { return impl_->parts().telemetry().log; }
std::optional<KeptEvents> Simulator::kept() const { return impl_->parts().kept(); }
std::span<const Slot> Simulator::slots() const noexcept { return impl_->slots(); }
std::int64_t Simulator::busy_ns() const noexcept { return impl_->busy_ns(); }

Result<Simulator> make_simulator(Scheme& scheme, LinearCostConfig cost, RunConfig config,
                                 Consumer consumer) noexcept {
  return made<Simulator>([&] {
    return std::make_unique<Simulator>(scheme, LinearCost(std::move(cost)), std::move(config),
                                       std::move(consumer));
  });
}

}  // namespace asap::inline v0_1
