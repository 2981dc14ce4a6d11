#include "asap/runner/replay.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <thread>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kLongestChunkNs = 1'000'000;            // of stamps in one push
constexpr auto kLongestSleep = std::chrono::milliseconds(20);  // a stop is seen this soon

ReplayConfig checked(ReplayConfig config) {
  require(config.speed >= 1e-3 && config.speed <= 1e6, "speed", config.speed,
          "must be between 0.001 and 1e6");
  require(config.pacing_us >= 0 && config.pacing_us <= 1000, "pacing_us", config.pacing_us,
          "must be between 0 and 1000 us");
  return config;
}

// Thrown by the producer to itself.
struct Stopped {};

}  // namespace

Replay::Replay(Scheme& scheme, ReplayConfig replay, RunConfig config)
    : replay_(checked(replay)),
      kept_mask_(config.keep_mask ? std::make_unique<KeptMask>() : nullptr),
      validator_(config.validator, kept_mask_ ? &kept_mask_->passed() : nullptr),
      telemetry_(latency_bound_ns(config, scheme)),
      buffer_(ring_capacity(config, telemetry_.latency.bound_ns())),
      intake_(buffer_, telemetry_.latency.bound_ns(), kept_mask_.get()),
      packager_(buffer_, intake_.ages(), scheme, telemetry_,
                packager_config(config, kept_mask_.get())),
      loop_(buffer_, packager_, telemetry_, doorbell_, clock_) {}

void Replay::run(EventSource& source, const Consumer& consumer, const Poll& poll) {
  if (buffer_.closed()) throw std::logic_error("replay: has run; make another one");
  std::exception_ptr producer_error;
  {
    std::jthread producer([&](const std::stop_token& stop) {
      const std::stop_callback unblock(stop, [&] { source.cancel(); });
      try {
        produce(source, stop);
      } catch (const Stopped&) {
      } catch (...) {
        producer_error = std::current_exception();
      }
      buffer_.close();
      doorbell_.wake();
    });
    loop_.run(consumer, poll);
  }
  if (producer_error) std::rethrow_exception(producer_error);
}

Ledger Replay::ledger() const noexcept {
  const bool finished = buffer_.closed();  // then what the producer owned may be read
  const std::uint64_t tail = buffer_.tail();
  Ledger ledger{.filtered = telemetry_.filtered,
                .discarded = telemetry_.discarded,
                .stale = telemetry_.stale,
                .overflow = buffer_.overflow(),
                .delivered = telemetry_.delivered,
                .pending = tail - buffer_.head()};
  if (finished) {
    ledger.received = validator_.received();
    ledger.rejected = validator_.rejected().total();
    ledger.pending += arriving_.size();
  } else {
    ledger.rejected = rejected_so_far_.load(std::memory_order_relaxed);
    ledger.received = ledger.rejected + ledger.overflow + tail;
  }
  return ledger;
}

void Replay::produce(EventSource& source, const std::stop_token& stop) {
  for (EventSpan chunk = source.next(); !chunk.empty(); chunk = source.next()) {
    validator_.check(chunk, [&](EventSpan good) {
      arriving_ = good;
      rejected_so_far_.store(validator_.rejected().total(), std::memory_order_relaxed);
      if (!started_) start(good.front());
      pace(stop);
    });
  }
}

void Replay::start(const Event& first) noexcept {
  const TimeAxis axis(first.t, replay_.speed);
  packager_.set_axis(axis);
  clock_.start(axis.to_ns(first.t));
  started_ = true;
}

void Replay::pace(const std::stop_token& stop) {
  while (!arriving_.empty()) {
    if (stop.stop_requested()) throw Stopped{};
    const std::int64_t wanted_ns =
        std::max(packager_.axis().to_ns(arriving_.front().t), next_push_ns_);
    if (clock_.now_ns() < wanted_ns) {
      const auto soon = System::now() + kLongestSleep;
      std::this_thread::sleep_until(std::min(clock_.when(wanted_ns), soon));
      continue;
    }
    push_arrived();
  }
}

void Replay::push_arrived() {
  const std::int64_t now_ns = clock_.now_ns();
  const std::int64_t first_ns = packager_.axis().to_ns(arriving_.front().t);
  const std::int64_t until_ns = std::min(now_ns, first_ns + kLongestChunkNs);
  std::size_t count = 1;
  while (count < arriving_.size() && packager_.axis().to_ns(arriving_[count].t) <= until_ns) {
    ++count;
  }
  intake_.push(arriving_.first(count), packager_.axis());
  doorbell_.announce(buffer_.tail());
  arriving_ = arriving_.subspan(count);
  lateness_.record(now_ns - first_ns);
  next_push_ns_ = until_ns + std::llround(replay_.pacing_us * 1e3);
}

}  // namespace asap
