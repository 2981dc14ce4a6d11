// The live pipeline: any configuration under any scheme, then any order of calls, with any events
// and arrival times. After each call the ledger is balanced and holds what was pushed; a refusal is
// of the documented kind and names its field; what the algorithm gets is ordered and in frame; and
// whatever has happened, a stop that drains leaves nothing behind. Nothing here waits for time.
#include <atomic>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "any_scheme.hpp"
#include "asap/runner/pipeline.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

using Next = Pipeline::Next;
using Steady = std::chrono::steady_clock;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

// The fuzzer's own alarm wakes who sleeps, which hides it.
constexpr auto kNoHang = std::chrono::seconds(8);

// What the algorithm, a filter or a poll throws; never what the library throws.
struct Mine {};

void check_refusal(const std::exception& refused) {
  fuzz::check(std::string(refused.what()).find(" = ") != std::string::npos);
}

std::int64_t odd_or(fuzz::Bytes& bytes, std::int64_t good_below) {
  const auto kind = bytes.take<std::uint8_t>();
  return kind < 6 ? bytes.take<std::int64_t>() : kind < 128 ? 0 : kind % good_below;
}

// In front of gamma: none, or one that keeps some events, and may throw a few times.
struct Front {
  int keep_every;
  int throws;

  std::size_t operator()(EventSpan events, std::span<Event> out) {
    if (throws > 0 && --throws % 2 == 0) throw Mine{};
    if (keep_every == 0) return 0;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < events.size(); i += static_cast<std::size_t>(keep_every)) {
      out[kept++] = events[i];
    }
    return kept;
  }
};

RunConfig any_run(fuzz::Bytes& bytes) {
  RunConfig config{.capacity = 1 + bytes.below(1 << (1 + bytes.below(11))),
                   .seed = bytes.take<std::uint8_t>(),
                   .execution = bytes.below(4) == 0 ? Execution::anytime : Execution::whole,
                   .flush = bytes.below(8) != 0,
                   .when_full = static_cast<WhenFull>(bytes.below(4))};
  if (bytes.below(32) == 0) config.capacity = (std::size_t{1} << 40) + 1;
  if (bytes.below(4) == 0) config.latency = bytes.time(10us, 10'000s);
  config.validator = {.width = static_cast<int>(odd_or(bytes, 400)),
                      .height = static_cast<int>(odd_or(bytes, 400)),
                      .on_bad = static_cast<OnBad>(bytes.below(3)),
                      .reorder_tolerance = nanoseconds(odd_or(bytes, 256'000)),
                      .warmup_discard = nanoseconds(odd_or(bytes, 256'000))};
  if (bytes.below(4) == 0) {
    config.front_filter = Front{.keep_every = static_cast<int>(bytes.below(4)),
                                .throws = static_cast<int>(bytes.below(3))};
  }
  return config;
}

Pipeline::Arrival any_arrival(fuzz::Bytes& bytes) {
  const auto kind = bytes.take<std::uint8_t>();
  const auto ago = nanoseconds(std::int64_t{bytes.take<std::uint16_t>()} << (kind % 20));
  if (kind < 100) return std::nullopt;
  if (kind < 200) return Steady::now() - ago;
  if (kind < 230) return Steady::now() + ago;
  if (kind < 238) return Steady::time_point::min();
  if (kind < 246) return Steady::time_point::max();
  return Steady::time_point(nanoseconds(bytes.take<std::int64_t>()));
}

void check_stats(const PipelineStats& stats) {
  fuzz::check(stats.ledger.balanced() && stats.ledger.rejected == stats.rejected.total());
  fuzz::check(stats.elapsed_ns >= 0);
  fuzz::check(stats.sensor_delay_ns >= 0 && stats.sensor_delay_ns <= stats.sensor_delay_max_ns);
  fuzz::check(stats.latency_bound_ns >= 10'000 && stats.latency_bound_ns <= 10'000'000'000'000);
  fuzz::check(stats.latency.max_ns() >= 0 && std::isfinite(stats.latency.mean_ns()));
}

// The algorithm: what it gets is as promised. It may throw, or end the run that it works for.
class Algorithm {
 public:
  Algorithm(const RunConfig& config, std::size_t ends_at)
      : width_(config.validator.width), height_(config.validator.height), ends_at_(ends_at) {}

  void look_at(const Package& package) {
    fuzz::check(!package.events.empty());
    fuzz::check(package.gamma >= 0.0 && package.gamma <= 1.0);
    fuzz::check(package.continues ? package.index + 1 == packages_ : package.index == packages_);
    packages_ = package.index + 1;
    for (const Event& event : package.events) {
      fuzz::check(event.t >= last_us_ && event.p >> 1 == 0);
      fuzz::check((width_ == 0 || event.x < width_) && (height_ == 0 || event.y < height_));
      last_us_ = event.t;
    }
  }
  bool ends() { return ends_at_ > 0 && --ends_at_ == 0; }
  void begin_anew() {
    packages_ = 0;
    last_us_ = -Validator::kMaxStamp_us;
  }

 private:
  int width_;
  int height_;
  std::size_t ends_at_;
  std::uint64_t packages_ = 0;
  std::int64_t last_us_ = -Validator::kMaxStamp_us;
};

// A camera that counts what it has handed over in this run.
class Camera {
 public:
  Camera(fuzz::Bytes& bytes, Pipeline& pipeline, bool waits)
      : bytes_(bytes), pipeline_(pipeline), waits_(waits) {}

  // To be given up at its first poll, which costs 20 ms: seldom.
  void push() {
    if (waits_ && waited_ > 0) return;
    const std::size_t max = bytes_.below(400);
    const auto events = bytes_.below(4) == 0 ? bytes_.events(max) : bytes_.stream(max);
    const bool open = pipeline_.is_open();
    try {
      const bool taken = pipeline_.push(events, any_arrival(bytes_), [this] {
        ++waited_;
        throw Mine{};
      });
      fuzz::check(taken == open || may_be_shut_);
      if (taken) min_ += events.size();
      if (taken) max_ += events.size();
    } catch (const std::invalid_argument& refused) {
      check_refusal(refused);
      max_ += events.size();
    } catch (const Mine&) {
      max_ += events.size();
    }
  }
  void check_received(const Ledger& ledger) const {
    fuzz::check(ledger.received >= min_ && ledger.received <= max_);
  }
  void begin_anew() { min_ = max_ = 0; }
  void may_be_shut_by_another_thread() { may_be_shut_ = true; }

 private:
  fuzz::Bytes& bytes_;
  Pipeline& pipeline_;
  const bool waits_;
  bool may_be_shut_ = false;
  int waited_ = 0;
  std::uint64_t min_ = 0;  // in pushes that were taken whole
  std::uint64_t max_ = 0;  // and in those that were refused or given up on the way
};

void set_any_latency(Pipeline& pipeline, fuzz::Bytes& bytes) {
  const nanoseconds latency = bytes.time(10us, 10'000s);
  try {
    pipeline.set_latency(latency);
    fuzz::check(pipeline.stats().latency_bound_ns == latency.count());
  } catch (const std::invalid_argument& refused) {
    check_refusal(refused);
    fuzz::check(latency < 10us || latency > 10'000s);
  }
}

// The consumer is this thread, so every moment between two calls is a quiescent one.
class ByHand {
 public:
  ByHand(fuzz::Bytes& bytes, Scheme& scheme, const RunConfig& config)
      : bytes_(bytes),
        whole_(config.execution == Execution::whole),
        pipeline_(scheme, config),
        algorithm_(config, bytes.below(6)),
        camera_(bytes, pipeline_, config.when_full == WhenFull::block) {}

  void play() {
    for (int calls = 0; calls < 200 && !bytes_.empty(); ++calls) {
      call();
      const Ledger ledger = pipeline_.ledger();
      fuzz::check(ledger.balanced() && ledger.pending <= ledger.received);
      camera_.check_received(ledger);
    }
    if (!bytes_.flag()) return;  // destructed as it is
    pipeline_.stop();
    while (!drained()) continue;
    const Ledger ledger = pipeline_.ledger();
    fuzz::check(ledger.balanced() && (given_up_ || ledger.pending == 0));
    fuzz::check(!whole_ || ledger.delivered == delivered_);
    camera_.check_received(ledger);
  }

 private:
  void call() {
    switch (bytes_.take<std::uint8_t>() % 16) {
      case 0:
        return finish();
      case 1:
        return run();
      case 2:
        return pipeline_.flush();
      case 3:
        return set_any_latency(pipeline_, bytes_);
      case 4:
        return stop(bytes_.below(4) != 0);
      case 5:
        return start();
      case 6:
        check_stats(pipeline_.stats());
        return pipeline_.upstream_lost(bytes_.take<std::uint64_t>(), bytes_.take<std::uint8_t>());
      case 7:
        return abandon();
      case 8:
      case 9:
      case 10:
      case 11:
        return next();
      default:
        return camera_.push();
    }
  }

  void next() try {
    const auto patience = nanoseconds(
        pipeline_.is_open() ? std::min<std::int64_t>(bytes_.take<std::int16_t>(), 0) : kNever);
    const auto begin = Steady::now();
    Package package;
    const Next next = pipeline_.next(package, patience);
    fuzz::check(Steady::now() - begin < kNoHang);
    finish_counting();
    in_work_ = next == Next::package;
    if (!in_work_) return;
    size_ = package.events.size();
    algorithm_.look_at(package);
  } catch (const std::logic_error&) {
    fuzz::check(!whole_);
  } catch (const Mine&) {  // of the filter in front; the package before is completed
    finish_counting();
  }

  void finish() {
    pipeline_.complete();
    finish_counting();
  }

  // The package in work, if there is one, has been delivered.
  void finish_counting() {
    if (in_work_) delivered_ += size_;
    in_work_ = false;
  }

  void run() {
    // Until its poll comes 20 ms go by, unless the run has an end.
    if (bytes_.below(64) != 0 || waits_-- == 0) stop(bytes_.below(4) != 0);
    try {
      pipeline_.run(
          [this](const Package& package) {
            finish_counting();
            algorithm_.look_at(package);
            if (algorithm_.ends()) throw Mine{};
            delivered_ += package.events.size();
          },
          [this] { stop(true); });
    } catch (const Mine&) {
      given_up_ = true;
    }
    finish_counting();
    fuzz::check(!pipeline_.is_open());
  }

  void stop(bool drain) {
    pipeline_.stop(drain);
    fuzz::check(!pipeline_.is_open());
    given_up_ |= !drain;
  }

  void abandon() {
    pipeline_.abandon();
    given_up_ = true;
    in_work_ = false;
  }

  void start() {
    const bool open = pipeline_.is_open();
    try {
      pipeline_.start();
    } catch (const std::logic_error&) {
      return fuzz::check(in_work_ && !open);
    }
    fuzz::check(pipeline_.is_open());
    if (open) return;
    fuzz::check(pipeline_.ledger() == Ledger{});
    algorithm_.begin_anew();
    camera_.begin_anew();
    delivered_ = 0;
    given_up_ = false;
  }

  bool drained() {
    if (!whole_) {
      run();
      return true;
    }
    next();
    return !in_work_ && (given_up_ || pipeline_.ledger().pending == 0);
  }

  fuzz::Bytes& bytes_;
  const bool whole_;
  Pipeline pipeline_;
  Algorithm algorithm_;
  Camera camera_;
  int waits_ = 1;
  bool in_work_ = false;
  bool given_up_ = false;  // something may stay pending
  std::size_t size_ = 0;   // of the package in work
  std::uint64_t delivered_ = 0;
};

// A thread of the pipeline's own works; a call may meet it anywhere.
class WithWorker {
 public:
  WithWorker(fuzz::Bytes& bytes, const RunConfig& config)
      : bytes_(bytes),
        algorithm_(config, bytes.below(6)),
        throws_(bytes.flag()),
        pipeline_(config, [this](const Package& package) { work(package); }),
        camera_(bytes, pipeline_, config.when_full == WhenFull::block) {
    camera_.may_be_shut_by_another_thread();
  }

  void play() {
    for (int calls = 0; calls < 40 && !bytes_.empty(); ++calls) {
      call();
      fuzz::check(pipeline_.ledger().balanced());
    }
    if (!bytes_.flag()) return;
    end();
    camera_.check_received(pipeline_.ledger());
    fuzz::check(failed_ || given_up_ || pipeline_.ledger().pending == 0);
  }

 private:
  void call() {
    switch (bytes_.take<std::uint8_t>() % 8) {
      case 0:
        check_stats(pipeline_.stats());
        return pipeline_.flush();
      case 1:
        return set_any_latency(pipeline_, bytes_);
      case 2:
        given_up_ = bytes_.flag();
        return pipeline_.stop(!given_up_);
      case 3:
        return end();
      case 4:
        return start();
      default:
        return camera_.push();
    }
  }

  void work(const Package& package) {
    algorithm_.look_at(package);
    if (!algorithm_.ends()) return;
    bool refused = false;
    try {
      pipeline_.join();
    } catch (const std::logic_error&) {
      refused = true;
    }
    fuzz::check(refused);
    if (throws_) throw Mine{};
    pipeline_.stop();
  }

  void end() {
    pipeline_.stop();
    try {
      pipeline_.join();
    } catch (const Mine&) {  // of the algorithm or the filter in front
      failed_ = true;
    }
    const Ledger ledger = pipeline_.ledger();
    fuzz::check(ledger.balanced());
    camera_.check_received(ledger);
  }

  void start() {
    end();
    pipeline_.stop();  // again, which changes nothing
    algorithm_.begin_anew();
    camera_.begin_anew();
    failed_ = given_up_ = false;
    pipeline_.start();
  }

  fuzz::Bytes& bytes_;
  Algorithm algorithm_;
  const bool throws_;
  Pipeline pipeline_;
  Camera camera_;
  bool failed_ = false;
  bool given_up_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  try {
    const auto scheme = fuzz::any_scheme(bytes);
    const RunConfig config = any_run(bytes);
    if (bytes.below(16) == 0) {
      WithWorker(bytes, config).play();
    } else {
      ByHand(bytes, *scheme, config).play();
    }
  } catch (const std::invalid_argument& refused) {
    check_refusal(refused);
  }
  return 0;
}
