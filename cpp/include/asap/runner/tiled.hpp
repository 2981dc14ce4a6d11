// Tiled: one algorithm on several threads, with the answers of one instance, to the bit. The sensor
// is cut into bands of rows; each has an instance of its own, which sees `reach` rows more on
// either side. For an algorithm whose answer to an event depends on no more than these rows: the
// corner detectors, PlaneFlow, BackgroundActivityFilter, ThresholdOrdinalSurface, and your own with
//
//   static int reach(const Config& config);  // rows; Config has `width` and `height`
//   using Answer = ...;                      // if it has process(events, std::span<Answer>)
//
// and with process(events), set_gamma, reset, rejected and config. It looks at differences of rows
// and of times alone, and takes a timestamp that goes back for the latest one: y counts from the
// first row that its band sees, times begin at 1 or later and never go back. Its state may count
// timestamps and pixels, not events: those of other rows are missing. With process(events, answers,
// places) too, see PlaneFlow, it is asked for no answer twice. One thread, or a frame too low for
// two bands, is the algorithm itself, called as it is.
//
// One thread at a time calls it; the others are its own. Whether they are worth their meeting is
// measured, by the size of the package. No allocation after construction; beside the instances it
// takes 0.7 MB for each thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

struct TiledConfig {
  int threads;  // the caller's included, 1 to 64
  // Called by each of the others, 1 and on, before all work: for its processor, its priority. They
  // are named asap-tiled-<number>.
  std::function<void(int)> on_worker_start = {};
};

namespace detail {

// The threads, and which events go where. Knows no algorithm.
class Bands {
 public:
  static constexpr std::size_t kMostEvents = 16'384;  // of one call

  // Rows of the sensor: the band's own, and those that it sees.
  struct Rows {
    int first;
    int end;
    int low;
    int high;
  };

  // What a band sees of a package, in its own coordinates; timestamps never go back.
  struct Part {
    std::size_t band;
    EventSpan events;
    const std::uint32_t* places;  // of the events in the package; beyond it: of another band's
    std::size_t package;          // events of all bands; 0: more of the same package
  };

  Bands(int width, int height, int reach, TiledConfig config,
        std::function<void(const Part&)> work);
  ~Bands();

  const std::vector<Rows>& all() const noexcept;

  // At most kMostEvents. Throws what `work` throws, and then std::runtime_error until reset().
  void process(EventSpan events, std::size_t package);
  void reset() noexcept;
  std::uint64_t rejected() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

[[noreturn]] void refuse_size(const char* field, std::size_t size, const char* remedy);

template <class A>
struct AnswerOf {
  using Type = std::uint8_t;  // unused
};
template <class A>
  requires requires { typename A::Answer; }
struct AnswerOf<A> {
  using Type = typename A::Answer;
};

}  // namespace detail

template <class A>
concept Tileable =
    requires(const typename A::Config& config) { static_cast<int>(A::reach(config)); };

template <Tileable A>
class Tiled {
  static constexpr bool kAnswers = requires { typename A::Answer; };
  static constexpr bool kFilters =
      requires(A& a, std::span<Event> out) { a.process(EventSpan(), out); };

 public:
  using Config = typename A::Config;
  using Answer = typename detail::AnswerOf<A>::Type;
  static_assert(!std::is_same_v<Answer, bool>, "Answer: a vector of bool is no array; use uint8_t");

  // Throws std::invalid_argument that names the bad field, std::system_error for a thread that the
  // system refuses, and what on_worker_start throws.
  Tiled(const Config& config, TiledConfig threads)
      : config_(A(config).config()),
        bands_(config.width, config.height, A::reach(config), std::move(threads),
               [this](const detail::Bands::Part& part) { work(part); }) {
    for (const auto& rows : bands_.all()) {
      Config own = config;
      own.height = rows.high - rows.low;
      instances_.push_back(std::make_unique<Instance>(own));
    }
    if constexpr (kAnswers) scratch_.resize(kMost);
  }

  Tiled(const Tiled&) = delete;
  Tiled& operator=(const Tiled&) = delete;

  // Events outside the frame are dropped and counted. Throws what the algorithm throws, on
  // whichever of several threads; then the state is lost: std::runtime_error until reset().
  void process(EventSpan events)
    requires(!kFilters)
  {
    if (is_one()) return static_cast<void>(one().process(events));
    in_parts(events, [&](EventSpan part, std::size_t) { process(part, scratch_, 0); });
  }

  // answers[i] is that to events[i]; Answer{} if it lies outside the frame. Throws
  // std::invalid_argument if the sizes differ.
  void process(EventSpan events, std::span<Answer> answers)
    requires(kAnswers && !kFilters)
  {
    if (answers.size() != events.size()) {
      detail::refuse_size("answers.size()", answers.size(), "must be the number of events");
    }
    if (is_one()) return static_cast<void>(one().process(events, answers));
    in_parts(events, [&](EventSpan part, std::size_t) {
      process(part, answers.subspan(static_cast<std::size_t>(part.data() - events.data())), 0);
    });
  }

  // A filter: see A::process.
  std::size_t process(EventSpan events, std::span<Event> out)
    requires kFilters
  {
    if (is_one()) return one().process(events, out);
    std::size_t passed = 0;
    in_parts(events, [&](EventSpan part, std::size_t package) {
      process(part, scratch_, package);
      for (std::size_t i = 0; i < part.size(); ++i) {
        out[passed] = part[i];
        passed += scratch_[i];
      }
    });
    return passed;
  }

  // A surface, row by row. Throws std::invalid_argument unless out.size() is width x height.
  template <class Value>
  void copy_to(std::span<Value> out) const
    requires requires(const A& a) { a.at(0, 0); }
  {
    if (out.size() !=
        static_cast<std::size_t>(config_.width) * static_cast<std::size_t>(config_.height)) {
      detail::refuse_size("out.size()", out.size(), "must be width x height");
    }
    auto to = out.begin();
    for (std::size_t i = 0; i < instances_.size(); ++i) {
      const auto& [first, end, low, high] = bands_.all()[i];
      for (int y = first - low; y < end - low; ++y) {
        for (int x = 0; x < config_.width; ++x) {
          *to++ = instances_[i]->algorithm.at(static_cast<std::uint32_t>(x),
                                              static_cast<std::uint32_t>(y));
        }
      }
    }
  }

  void set_gamma(double gamma) {
    for (const auto& instance : instances_) instance->algorithm.set_gamma(gamma);
  }

  void reset() {
    for (const auto& instance : instances_) instance->algorithm.reset();
    bands_.reset();
  }

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept {
    return is_one() ? instances_[0]->algorithm.rejected() : bands_.rejected();
  }

  const Config& config() const noexcept { return config_; }

 private:
  static constexpr std::size_t kMost = detail::Bands::kMostEvents;

  static constexpr bool kPlaces =
      requires(A& a, const std::uint32_t* places) { a.process(EventSpan(), {}, places); };

  struct Instance {
    explicit Instance(const Config& config)
        : algorithm(config), answers(kAnswers && !kPlaces ? kMost : 0) {}

    A algorithm;
    std::vector<Answer> answers;
  };

  bool is_one() const noexcept { return instances_.size() == 1; }
  A& one() noexcept { return instances_[0]->algorithm; }

  template <class Do>
  static void in_parts(EventSpan events, Do act) {
    for (std::size_t package = events.size(); !events.empty(); package = 0) {
      const EventSpan part = events.first(std::min(events.size(), kMost));
      act(part, package);
      events = events.subspan(part.size());
    }
  }

  void process(EventSpan events, std::span<Answer> answers, std::size_t package) {
    if constexpr (kAnswers) answers_ = answers.first(events.size());
    std::fill(answers_.begin(), answers_.end(), Answer{});
    bands_.process(events, package);
  }

  void work(const detail::Bands::Part& part) {
    if (!kFilters && part.events.empty()) return;
    auto& [algorithm, all] = *instances_[part.band];
    if constexpr (kPlaces) {
      algorithm.process(part.events, answers_, part.places);
    } else if constexpr (kAnswers) {
      const std::span own = std::span(all).first(part.events.size());
      if constexpr (kFilters) {
        algorithm.process(part.events, own, part.package);
      } else {
        algorithm.process(part.events, own);
      }
      for (std::size_t i = 0; i < own.size(); ++i) {
        if (part.places[i] < answers_.size()) answers_[part.places[i]] = own[i];
      }
    } else {
      algorithm.process(part.events);
    }
  }

  Config config_;
  std::vector<std::unique_ptr<Instance>> instances_;  // one for each band
  std::vector<Answer> scratch_;
  std::span<Answer> answers_;  // of the package in work
  detail::Bands bands_;        // last: its threads use the others
};

}  // namespace asap::inline v0_1
