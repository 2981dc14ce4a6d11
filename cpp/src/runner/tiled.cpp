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
#include "runner/process.hpp"
#include "runner/system.hpp"

#if defined(__linux__)
#include <pthread.h>
#endif

namespace asap::inline v0_1::detail {
namespace {

constexpr int kMostThreads = 64;
constexpr std::uint32_t kNoPlace = UINT32_MAX;
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
    require(reach >= 0, "reach", reach, "must be 0 or more rows");
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
    left_.store(workers(), std::memory_order_relaxed);
    for (std::size_t number = 1; number < lanes_.size(); ++number) {
      try {
        workers_.emplace_back([this, number] { live(number); });
      } catch (const std::system_error& refused) {
        throw std::system_error(refused.code(), "threads = " + std::to_string(lanes_.size()) +
                                                    ": the system refuses one; ask for fewer");
      }
    }
    wait_for_workers();
    rethrow();
  }

  const std::vector<Rows>& all() const noexcept { return all_; }
  std::uint64_t rejected() const noexcept { return rejected_; }

  void process(EventSpan events, std::size_t package) {
    if (failed_.load(std::memory_order_relaxed)) {
      throw std::runtime_error("the algorithm threw, and its state is lost: call reset() first");
    }
    FasterWay& way = ways_[static_cast<std::size_t>(std::bit_width(events.size()))];
    const auto begin = System::now();
    events_ = events;
    package_ = package;
    const bool by_all = way.all() && has_workers() && time_.has_begun();
    if (by_all) {
      is_jagged_.store(false, std::memory_order_relaxed);
      unrouted_.store(workers() + 1, std::memory_order_relaxed);
      left_.store(workers(), std::memory_order_relaxed);
      call_workers();
      take_share(0);
      wait_for_workers();
    }
    if (!by_all || is_jagged_.load(std::memory_order_relaxed)) {
      take_all();
    } else {
      for (const Lane& lane : lanes_) rejected_ += lane.rejected;
      time_.of(latest_us_);
    }
    rethrow();
    const std::chrono::duration<double, std::nano> took = System::now() - begin;
    way.took(by_all, took.count() / static_cast<double>(events.size()));
  }

  void reset() noexcept {
    time_ = {};
    rejected_ = 0;
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

  // The time of the whole stream. It counts as one instance counts it, never goes back, and is
  // positive: a cell without an event may count as fired at 0.
  class Time {
   public:
    std::int64_t of(std::int64_t stamp_us) noexcept {
      constexpr std::int64_t kLongSince = std::int64_t{1} << 40;  // for every window
      if (!clock_.started()) first_us_ = std::clamp<std::int64_t>(stamp_us, 1, kLongSince);
      clock_.advance(stamp_us);
      return first_us_ + static_cast<std::int64_t>(clock_.now_us() - EventClock::kOrigin_us);
    }
    bool has_begun() const noexcept { return clock_.started(); }
    std::int64_t latest_us() const noexcept { return clock_.latest_us(); }

   private:
    EventClock clock_;
    std::int64_t first_us_ = 0;
  };

  // Each lane has its part of these arrays, which begins where its events begin in the package.
  struct Band {
    std::vector<Event> events = std::vector<Event>(kMostEvents);
    std::vector<std::uint32_t> places = std::vector<std::uint32_t>(kMostEvents);
    std::size_t load = 0;    // events in the package
    std::size_t thread = 0;  // that works for it
  };

  // The band whose own a row is, and the bands that see it.
  struct SeenBy {
    std::uint16_t owner = 0;
    std::uint16_t begin = 0;
    std::uint16_t end = 0;
  };

  // Where events of a band go to.
  struct Target {
    Event* events;
    std::uint32_t* places;
    std::size_t size;
    std::uint32_t low;
  };

  // The part of a package that one thread deals out.
  struct alignas(64) Lane {
    explicit Lane(std::size_t bands) : targets(bands) {}

    std::vector<Target> targets;  // one for each band
    std::uint64_t rejected = 0;
    std::int64_t latest_us = 0;  // of those in the frame
    std::size_t load = 0;        // events of its bands
  };

  bool has(const Event& event) const noexcept {
    return event.x < width_ && event.y < seen_by_.size();
  }
  bool has_workers() const noexcept { return this_process() == process_; }
  std::uint32_t workers() const noexcept { return static_cast<std::uint32_t>(lanes_.size() - 1); }

  void call_workers() noexcept {
    calls_.fetch_add(1, std::memory_order_release);
    calls_.notify_all();
  }

  void wait_for_workers() noexcept {
    while (const std::uint32_t left = left_.load(std::memory_order_acquire)) {
      wait_while(left_, left);
    }
  }

  // What a thread threw.
  void rethrow() {
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

  // Deals out a share of the events, waits for the others to do so, and works for its bands.
  void take_share(std::size_t thread) noexcept {
    const std::uint32_t seen = dealt_.load(std::memory_order_relaxed);
    const std::size_t begin = events_.size() * thread / lanes_.size();
    const std::size_t end = events_.size() * (thread + 1) / lanes_.size();
    std::size_t before = begin;
    while (before > 0 && !has(events_[before - 1])) --before;
    const std::int64_t latest_us = time_.latest_us();
    const auto now_us = static_cast<std::uint64_t>(Time(time_).of(latest_us));
    std::int64_t before_us = before > 0 ? events_[before - 1].t : latest_us;
    bool goes_back = false;
    route(lanes_[thread], begin, end, [&](std::int64_t stamp_us) {
      goes_back |= stamp_us < before_us;
      before_us = stamp_us;
      return static_cast<std::int64_t>(now_us + distance_us(latest_us, stamp_us));
    });
    if (goes_back) is_jagged_.store(true, std::memory_order_relaxed);
    if (unrouted_.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      latest_us_ = time_.latest_us();
      for (const Lane& lane : lanes_) latest_us_ = std::max(latest_us_, lane.latest_us);
      if (distance_us(time_.latest_us(), latest_us_) > EventClock::kLongestStep_us) {
        is_jagged_.store(true, std::memory_order_relaxed);
      }
      deal();
      dealt_.store(seen + 1, std::memory_order_release);
      dealt_.notify_all();
    } else {
      wait_while(dealt_, seen);
    }
    if (is_jagged_.load(std::memory_order_relaxed)) return;
    attempt([&] {
      for (std::size_t band = 0; band < bands_.size(); ++band) {
        if (bands_[band].thread != thread) continue;
        for (std::size_t lane = 0; lane < lanes_.size(); ++lane) work_for(band, lane);
      }
    });
  }

  // Without the others.
  void take_all() noexcept {
    route(lanes_[0], 0, events_.size(), [&](std::int64_t stamp_us) { return time_.of(stamp_us); });
    rejected_ += lanes_[0].rejected;
    attempt([&] {
      for (std::size_t band = 0; band < bands_.size(); ++band) work_for(band, 0);
    });
  }

  void work_for(std::size_t band, std::size_t lane) {
    if (failed_.load(std::memory_order_relaxed)) return;
    const Target& from = lanes_[lane].targets[band];
    work_({band, EventSpan(from.events, from.size), from.places, lane == 0 ? package_ : 0});
  }

  template <class TimeOf>
  void route(Lane& lane, std::size_t begin, std::size_t end, TimeOf time_of) noexcept {
    for (std::size_t i = 0; i < bands_.size(); ++i) {
      lane.targets[i] = {&bands_[i].events[begin], &bands_[i].places[begin], 0,
                         static_cast<std::uint32_t>(all_[i].low)};
    }
    // In registers: what is written might be any of these.
    const std::span<const SeenBy> seen_by = seen_by_;
    Target* const targets = lane.targets.data();
    const std::uint32_t width = width_;
    const Event* const events = events_.data();
    std::uint64_t rejected = 0;
    std::int64_t latest_us = time_.latest_us();
    for (std::size_t i = begin; i < end; ++i) {
      const Event event = events[i];
      if (event.x >= width || event.y >= seen_by.size()) [[unlikely]] {
        ++rejected;
        continue;
      }
      latest_us = event.t;
      const std::int64_t t = time_of(event.t);
      const auto put = [&](std::size_t band, std::uint32_t place) {
        Target& to = targets[band];
        const std::size_t at = to.size++;
        const auto y = static_cast<std::uint16_t>(event.y - to.low);
        to.places[at] = place;
        to.events[at] = {.x = event.x, .y = y, .p = event.p, .t = t};
      };
      const SeenBy& seen = seen_by[event.y];
      put(seen.owner, static_cast<std::uint32_t>(i));
      if (seen.end == seen.begin + 1) [[likely]]
        continue;
      for (std::size_t band = seen.begin; band < seen.end; ++band) {
        if (band != seen.owner) put(band, kNoPlace);
      }
    }
    lane.rejected = rejected;
    lane.latest_us = latest_us;
  }

  // Deals the bands to the threads, the busiest first, each to the one with the least. A sensor is
  // read out row by row, so every package has its own busy bands.
  void deal() noexcept {
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      bands_[band].load = 0;
      for (const Lane& lane : lanes_) bands_[band].load += lane.targets[band].size;
    }
    std::sort(by_load_.begin(), by_load_.end(),
              [](const Band* a, const Band* b) { return a->load > b->load; });
    for (Lane& lane : lanes_) lane.load = 0;
    for (Band* band : by_load_) {
      const auto least =
          std::min_element(lanes_.begin(), lanes_.end(),
                           [](const Lane& a, const Lane& b) { return a.load < b.load; });
      band->thread = static_cast<std::size_t>(least - lanes_.begin());
      least->load += band->load;
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
  Time time_;                                                      // before the package in work
  std::uint64_t rejected_ = 0;

  // The package in work.
  EventSpan events_;
  std::size_t package_ = 0;
  std::int64_t latest_us_ = 0;          // timestamp in the frame
  std::atomic<bool> is_jagged_{false};  // for one thread: a timestamp goes back, or far ahead

  std::exception_ptr error_;  // of the thread that failed first
  std::atomic<bool> failed_{false};
  std::atomic<bool> stops_{false};
  alignas(64) std::atomic<std::uint32_t> calls_{0};
  alignas(64) std::atomic<std::uint32_t> unrouted_{0};  // lanes
  alignas(64) std::atomic<std::uint32_t> dealt_{0};     // packages
  alignas(64) std::atomic<std::uint32_t> left_{0};      // threads
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

void refuse_size(const char* field, std::size_t size, const char* remedy) {
  throw_bad_value(field, std::to_string(size), remedy);
}

}  // namespace asap::inline v0_1::detail
