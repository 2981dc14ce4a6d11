#include "asap/runner/replay.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <stop_token>
#include <thread>

#include "core/check.hpp"
#include "runner/clock.hpp"
#include "runner/consumer_loop.hpp"
#include "runner/doorbell.hpp"
#include "runner/run.hpp"
#include "schemes/scheme_hold.hpp"

#if defined(__linux__)
#include <sys/prctl.h>
#endif

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kLongestChunkNs = 1'000'000;  // of timestamps in one push

ReplayConfig checked(ReplayConfig config) {
  using namespace std::chrono_literals;
  require(config.speed >= 1e-3 && config.speed <= 1e6, "speed", config.speed,
          "must be between 0.001 and 1e6");
  require_time(config.pacing >= 0us && config.pacing <= 1ms, "pacing", config.pacing, TimeUnit::us,
               "must be between 0 and 1000 us");
  return config;
}

// Linux lets a sleep of this thread last 50 us longer unless told: as long as the pacing.
void sleep_exactly() noexcept {
#if defined(__linux__)
  prctl(PR_SET_TIMERSLACK, 1UL);
#endif
}

// Thrown by the producer to itself.
struct Stopped {};

}  // namespace

class Replay::Impl {
 public:
  Impl(Scheme& scheme, ReplayConfig replay, const RunConfig& config)
      : replay_(checked(replay)),
        hold_(scheme),
        run_(scheme, config, Run::Source::recording),
        loop_(run_.buffer(), run_.packager(), run_.telemetry(), doorbell_, clock_) {
    hold_.release();  // until run()
  }

  void run(EventSource& source, const Consumer& consumer, const Poll& poll);
  Run::Outside outside() const noexcept;
  Ledger ledger() const noexcept { return run_.ledger(outside()); }
  RunStats stats() const;
  const Run& parts() const noexcept { return run_; }
  const LatencyHistogram& lateness() const noexcept { return lateness_; }

 private:
  void produce(EventSource& source, const std::stop_token& stop);
  void start(const Event& first) noexcept;
  void pace(const std::stop_token& stop);
  void push_arrived();

  const ReplayConfig replay_;
  SchemeHold hold_;
  Run run_;
  Doorbell doorbell_;
  RunClock clock_;
  ConsumerLoop loop_;

  // The producer's. Of the chunk being replayed: events that have not arrived yet.
  EventSpan arriving_;
  bool started_ = false;
  std::int64_t next_push_ns_ = kLongAgo;
  LatencyHistogram lateness_;
};

void Replay::Impl::run(EventSource& source, const Consumer& consumer, const Poll& poll) {
  if (run_.buffer().closed()) throw std::logic_error("replay: has run; make another one");
  hold_.take();
  struct Free {
    SchemeHold& hold;
    ~Free() { hold.release(); }
  } const free{hold_};
  run_.guard([&] {
    std::exception_ptr producer_error;
    {
      std::jthread producer([&](const std::stop_token& stop) {
        sleep_exactly();
        const std::stop_callback unblock(stop, [&] { source.cancel(); });
        try {
          produce(source, stop);
        } catch (const Stopped&) {
        } catch (...) {
          producer_error = std::current_exception();
        }
        run_.buffer().close();
        doorbell_.wake();
      });
      loop_.run(consumer, poll);
    }
    if (producer_error) std::rethrow_exception(producer_error);
  });
}

// Once the producer has closed the ring, what it owned may be read.
Run::Outside Replay::Impl::outside() const noexcept {
  const bool is_quiet = run_.buffer().closed();
  return {is_quiet, 0, is_quiet ? arriving_.size() : 0};
}

RunStats Replay::Impl::stats() const {
  RunStats stats;
  run_.copy_stats_to(stats, outside());
  stats.gap_us = std::llround(static_cast<double>(run_.gap_us()) / replay_.speed);
  return stats;
}

void Replay::Impl::produce(EventSource& source, const std::stop_token& stop) {
  for (EventSpan chunk = source.next(); !chunk.empty(); chunk = source.next()) {
    run_.validator().check(chunk, [&](EventSpan good) {
      arriving_ = good;
      run_.publish();
      if (!started_) start(good.front());
      pace(stop);
    });
  }
}

void Replay::Impl::start(const Event& first) noexcept {
  run_.begin(first.t, replay_.speed);
  clock_.start(run_.axis().to_ns(first.t));
  started_ = true;
}

void Replay::Impl::pace(const std::stop_token& stop) {
  while (!arriving_.empty()) {
    if (stop.stop_requested()) throw Stopped{};
    const std::int64_t wanted_ns = std::max(run_.axis().to_ns(arriving_.front().t), next_push_ns_);
    if (clock_.now_ns() < wanted_ns) {
      const auto soon = System::now() + kPollEvery;
      std::this_thread::sleep_until(std::min(clock_.when(wanted_ns), soon));
      continue;
    }
    push_arrived();
  }
}

void Replay::Impl::push_arrived() {
  const std::int64_t now_ns = clock_.now_ns();
  const std::int64_t first_ns = run_.axis().to_ns(arriving_.front().t);
  const std::int64_t until_ns = std::min(now_ns, first_ns + kLongestChunkNs);
  std::size_t count = 1;
  while (count < arriving_.size() && run_.axis().to_ns(arriving_[count].t) <= until_ns) ++count;
  run_.arrive(arriving_.first(count));
  doorbell_.announce(run_.buffer().tail());
  arriving_ = arriving_.subspan(count);
  lateness_.record(now_ns - first_ns);
  next_push_ns_ = until_ns + replay_.pacing.count();
}

Replay::Replay(Scheme& scheme, ReplayConfig replay, RunConfig config)
    : impl_(std::make_unique<Impl>(scheme, replay, config)) {}

Replay::~Replay() = default;

void Replay::run(EventSource& source, const Consumer& consumer, const Poll& poll) {
  impl_->run(source, given(consumer), poll);
}

Ledger Replay::ledger() const noexcept { return impl_->ledger(); }
const Validator& Replay::validator() const noexcept { return impl_->parts().validator(); }
RunStats Replay::stats() const { return impl_->stats(); }
const RunLog& Replay::log() const noexcept { return impl_->parts().telemetry().log; }
std::optional<KeptEvents> Replay::kept() const { return impl_->parts().kept(); }
const LatencyHistogram& Replay::lateness() const noexcept { return impl_->lateness(); }

}  // namespace asap::inline v0_1
