#include "asap/runner/tiled.hpp"

#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/check.hpp"
#include "core/event_clock.hpp"
#include "runner/system.hpp"

#if defined(__linux__)
#include <pthread.h>
#include <unistd.h>
#endif

namespace asap::inline v0_1::detail {
namespace {

constexpr int kMostThreads = 64;
// So that those of a busy half can be dealt to several; each adds its neighbours' rows to the work.
constexpr int kBandsPerThread = 2;

// Looks for as long as it costs to be woken, about, before it sleeps. It yields to no other
// process, which would keep the processor for longer.
void wait_while(std::atomic<std::uint32_t>& word, std::uint32_t value) noexcept {
  const auto until = System::now() + std::chrono::microseconds(50);
  while (word.load(std::memory_order_acquire) == value) {
    if (System::now() >= until) return word.wait(value, std::memory_order_acquire);
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
}

// A process that forked has no workers: they stay with its parent.
std::int64_t this_process() noexcept {
#if defined(__linux__)
  return getpid();
#else
  return 0;
#endif
}

void name_this_thread(int number) noexcept {
#if defined(__linux__)
  pthread_setname_np(pthread_self(), ("asap-tiled-" + std::to_string(number)).c_str());
#else
  static_cast<void>(number);
#endif
}

}  // namespace

class Bands::Impl {
 public:
  Impl(int width, int height, int reach, TiledConfig config, std::function<void(const Part&)> work)
      : width_(static_cast<std::uint32_t>(width)), work_(std::move(work)) {
    require(1 <= config.threads && config.threads <= kMostThreads, "threads", config.threads,
            "must be 1 to 64");
    const int room = height / std::max(1, 2 * reach);
    const int count =
        config.threads == 1 ? 1 : std::clamp(room, 1, kBandsPerThread * config.threads);
    for (int i = 0; i < count; ++i) {
      const int first = height * i / count;
      const int end = height * (i + 1) / count;
      all_.push_back({first, end, std::max(0, first - reach), std::min(height, end + reach)});
    }
    if (count == 1) return;
    seen_by_.resize(static_cast<std::size_t>(height));
    for (const Rows& rows : all_) {
      const auto number = static_cast<std::uint16_t>(bands_.size());
      for (int y = rows.low; y < rows.high; ++y) {
        SeenBy& seen = seen_by_[static_cast<std::size_t>(y)];
        if (seen.end == 0) seen.begin = number;
        seen.end = static_cast<std::uint16_t>(number + 1);
        if (rows.first <= y && y < rows.end) seen.owner = number;
      }
      bands_.emplace_back();
    }
    for (Band& band : bands_) by_load_.push_back(&band);
    lanes_.resize(static_cast<std::size_t>(std::min(config.threads, count)), Lane(bands_.size()));
    on_worker_start_ = std::move(config.on_worker_start);
  }

  ~Impl() {
    if (!has_workers()) {
      for (std::thread& worker : workers_) worker.detach();
      return;
    }
    stops_.store(true, std::memory_order_relaxed);
    call_workers();
    for (std::thread& worker : workers_) worker.join();
  }

  void start() {
    left_.store(static_cast<std::uint32_t>(lanes_.size() - 1), std::memory_order_relaxed);
    for (std::size_t number = 1; number < lanes_.size(); ++number) {
      workers_.emplace_back([this, number] { live(number); });
    }
    wait_for_workers();
  }

  const std::vector<Rows>& all() const noexcept { return all_; }
  std::uint64_t rejected() const noexcept { return scan_.rejected; }

  void process(EventSpan events, std::size_t package) {
    if (failed_.load(std::memory_order_relaxed)) {
      throw std::runtime_error("the algorithm threw, and its state is lost: call reset() first");
    }
    FasterWay& way = ways_[static_cast<std::size_t>(std::bit_width(events.size()))];
    const auto begin = System::now();
    events_ = events;
    package_ = package;
    all_work_ = way.all() && has_workers();
    if (all_work_) {
      deal();
      left_.store(static_cast<std::uint32_t>(lanes_.size() - 1), std::memory_order_relaxed);
      call_workers();
    }
    take_share(0);
    wait_for_workers();
    const std::chrono::duration<double, std::nano> took = System::now() - begin;
    way.took(all_work_, took.count() / static_cast<double>(events.size()));
    scan_ = lanes_[0].scan;
  }

  void reset() noexcept {
    scan_ = {};
    failed_.store(false, std::memory_order_relaxed);
  }

 private:
  // One thread or all, for packages of one size: what took less lately. The other is tried for some
  // packages now and then: the first comes with a cold cache. One that was interrupted counts
  // little.
  class FasterWay {
   public:
    bool all() noexcept { return (packages_++ % 128 < 4) != (ns_[1] < ns_[0]); }

    void took(bool all, double ns_per_event) noexcept {
      double& ns = ns_[all ? 1 : 0];
      ns = ns == 0 ? ns_per_event : std::min((ns + ns_per_event) / 2, 1.1 * ns);
    }

   private:
    std::array<double, 2> ns_{};  // by one thread, by all
    unsigned packages_ = 0;
  };

  struct Band {
    std::vector<Event> events = std::vector<Event>(kMostEvents);
    std::vector<std::uint32_t> places = std::vector<std::uint32_t>(kMostEvents);
    std::size_t thread = 0;  // that works for it when all do
    std::size_t load = 0;    // events of its own in the package
  };

  // The bands that see a row, and the one whose own it is.
  struct SeenBy {
    std::uint16_t begin = 0;
    std::uint16_t end = 0;
    std::uint16_t owner = 0;
  };

  // Where the events of a band go to; those of another thread's band go nowhere, without a branch.
  struct Target {
    Event* events;
    std::uint32_t* places;
    std::size_t size;
    std::size_t step;
    std::uint32_t low;
  };

  // The whole stream so far. Time counts as one instance counts it, never goes back, and is
  // positive: a cell without an event may count as fired at 0.
  struct Scan {
    std::int64_t time_of(std::int64_t stamp_us) noexcept {
      constexpr std::int64_t kLongSince = std::int64_t{1} << 40;  // for every window
      if (!clock.started()) first_us = std::clamp<std::int64_t>(stamp_us, 1, kLongSince);
      clock.advance(stamp_us);
      return first_us + static_cast<std::int64_t>(clock.now_us() - EventClock::kOrigin_us);
    }

    EventClock clock;
    std::int64_t first_us = 0;
    std::uint64_t rejected = 0;
  };

  // What one thread needs.
  struct alignas(64) Lane {
    explicit Lane(std::size_t bands) : targets(bands) {}

    std::vector<Target> targets;
    Scan scan{};
    std::size_t load = 0;
    Event nowhere{};
    std::uint32_t no_place = 0;
  };

  bool has_workers() const noexcept { return this_process() == process_; }

  void call_workers() noexcept {
    calls_.fetch_add(1, std::memory_order_release);
    calls_.notify_all();
  }

  // Throws what a thread threw.
  void wait_for_workers() {
    while (const std::uint32_t left = left_.load(std::memory_order_acquire))
      wait_while(left_, left);
    if (failed_.load(std::memory_order_relaxed)) std::rethrow_exception(std::exchange(error_, {}));
  }

  void live(std::size_t number) noexcept {
    name_this_thread(static_cast<int>(number));
    attempt([&] {
      if (on_worker_start_) on_worker_start_(static_cast<int>(number));
    });
    for (std::uint32_t seen = 0;; ++seen) {
      if (left_.fetch_sub(1, std::memory_order_acq_rel) == 1) left_.notify_one();
      wait_while(calls_, seen);
      if (stops_.load(std::memory_order_relaxed)) return;
      take_share(number);
    }
  }

  template <class Do>
  void attempt(Do act) noexcept {
    try {
      act();
    } catch (...) {
      if (!failed_.exchange(true)) error_ = std::current_exception();
    }
  }

  void take_share(std::size_t thread) noexcept {
    Lane& lane = lanes_[thread];
    const auto is_mine = [&](const Band& band) { return !all_work_ || band.thread == thread; };
    for (std::size_t i = 0; i < bands_.size(); ++i) {
      Band& band = bands_[i];
      lane.targets[i] = is_mine(band) ? Target{band.events.data(), band.places.data(), 0, 1,
                                               static_cast<std::uint32_t>(all_[i].low)}
                                      : Target{&lane.nowhere, &lane.no_place, 0, 0, 0};
    }
    route(lane);
    attempt([&] {
      for (std::size_t i = 0; i < bands_.size(); ++i) {
        Band& band = bands_[i];
        if (!is_mine(band) || failed_.load(std::memory_order_relaxed)) continue;
        const std::size_t size = lane.targets[i].size;
        work_({i, EventSpan(band.events).first(size), band.places.data(), package_});
      }
    });
  }

  void route(Lane& lane) const noexcept {
    Scan scan = scan_;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const Event& event = events_[i];
      if (event.x >= width_ || event.y >= seen_by_.size()) [[unlikely]] {
        ++scan.rejected;
        continue;
      }
      const std::int64_t t = scan.time_of(event.t);
      const SeenBy seen = seen_by_[event.y];
      for (std::size_t band = seen.begin; band < seen.end; ++band) {
        Target& to = lane.targets[band];
        to.events[to.size] = {
            .x = event.x, .y = static_cast<std::uint16_t>(event.y - to.low), .p = event.p, .t = t};
        to.places[to.size] = band == seen.owner ? static_cast<std::uint32_t>(i) : Part::kNone;
        to.size += to.step;
      }
    }
    lane.scan = scan;
  }

  // Deals the bands to the threads, the busiest first, each to the one with the least. A sensor is
  // read out row by row, so every package has its own busy bands.
  void deal() noexcept {
    for (const Event& event : events_) {
      if (event.y < seen_by_.size()) ++bands_[seen_by_[event.y].owner].load;
    }
    std::sort(by_load_.begin(), by_load_.end(),
              [](const Band* a, const Band* b) { return a->load > b->load; });
    for (Lane& lane : lanes_) lane.load = 0;
    for (Band* band : by_load_) {
      const auto least =
          std::min_element(lanes_.begin(), lanes_.end(),
                           [](const Lane& a, const Lane& b) { return a.load < b.load; });
      band->thread = static_cast<std::size_t>(least - lanes_.begin());
      least->load += std::exchange(band->load, 0);
    }
  }

  std::uint32_t width_;
  std::function<void(const Part&)> work_;
  std::function<void(int)> on_worker_start_;
  std::vector<Rows> all_;
  std::vector<SeenBy> seen_by_;  // each row
  std::vector<Band> bands_;
  std::vector<Band*> by_load_;
  std::vector<Lane> lanes_;                                        // one for each thread
  std::array<FasterWay, std::bit_width(kMostEvents) + 1> ways_{};  // by the size of a package
  Scan scan_;                                                      // without the package in work

  // The package in work.
  EventSpan events_;
  std::size_t package_ = 0;
  bool all_work_ = true;

  std::exception_ptr error_;  // of the thread that failed first
  std::atomic<bool> failed_{false};
  std::atomic<bool> stops_{false};
  alignas(64) std::atomic<std::uint32_t> calls_{0};
  alignas(64) std::atomic<std::uint32_t> left_{0};
  std::vector<std::thread> workers_;
  const std::int64_t process_ = this_process();
};

Bands::Bands(int width, int height, int reach, TiledConfig config,
             std::function<void(const Part&)> work)
    : impl_(std::make_unique<Impl>(width, height, reach, std::move(config), std::move(work))) {
  if (all().size() > 1) impl_->start();
}
Bands::~Bands() = default;
const std::vector<Bands::Rows>& Bands::all() const noexcept { return impl_->all(); }
void Bands::process(EventSpan events, std::size_t package) { impl_->process(events, package); }
void Bands::reset() noexcept { impl_->reset(); }
std::uint64_t Bands::rejected() const noexcept { return impl_->rejected(); }

void refuse_answers(std::size_t answers) {
  throw_bad_value("answers.size()", std::to_string(answers), "must be the number of events");
}

}  // namespace asap::inline v0_1::detail
