// Scheme: the rule that decides size and gamma of the next package. The one seam of the library:
// a scheme is told what waits (Backlog) and answers with a Decision; afterwards it is told what the
// package really cost (Outcome). It reads no clock, draws no random number, touches no ring and
// allocates nothing. Called on the consumer's thread, once or twice per package. Times are ns of
// the run's axis (core/time.hpp).
//
//   class Halves final : public Scheme {
//    public:
//     Decision decide(const Backlog& backlog) noexcept override {
//       return Decision::take(backlog.count, /*gamma=*/0.5);
//     }
//     void observe(const Outcome&) noexcept override {}
//     std::string_view name() const noexcept override { return "halves"; }
//   };
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "asap/core/nonblocking.hpp"
#include "asap/core/result.hpp"
#include "asap/core/time.hpp"

namespace asap::inline v0_1 {

// The parameters of a scheme by name. A configuration lists its fields once, in kParameters, in the
// order of the constructor's keywords:
//
//   static constexpr std::tuple kParameters{NamedField{"size", &FixedSizeConfig::size}};
//
// From that list come the values that a scheme tells and, in Python, the keywords, defaults and
// signature of its constructor, the stub and the command line. Any thread; parameters_of allocates.

// The constructor's parameters by name. A choice is given by its name.
using SchemeParameter = std::variant<std::int64_t, double, std::string_view>;
using SchemeParameters = std::vector<std::pair<std::string_view, SchemeParameter>>;

template <class Config, class Value>
struct NamedField {
  const char* name;
  Value Config::* field;
};
template <class Config, class Value>
NamedField(const char*, Value Config::*) -> NamedField<Config, Value>;

// The values in the order of Config::kParameters. An optional one without a value is left out; a
// time is given in ms, as its name says.
template <class Config>
SchemeParameters parameters_of(const Config& config) {
  SchemeParameters parameters;
  const auto add = [&parameters](const char* name, const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::optional<double>>) {
      if (value) parameters.emplace_back(name, *value);
    } else if constexpr (std::is_same_v<Value, std::size_t>) {
      parameters.emplace_back(name, static_cast<std::int64_t>(value));
    } else if constexpr (std::is_same_v<Value, std::chrono::nanoseconds>) {
      parameters.emplace_back(name, static_cast<double>(value.count()) / 1e6);
    } else if constexpr (std::is_enum_v<Value>) {
      parameters.emplace_back(name, name_of(value));
    } else {
      parameters.emplace_back(name, value);
    }
  };
  std::apply([&](const auto&... rows) { (add(rows.name, config.*rows.field), ...); },
             Config::kParameters);
  return parameters;
}

// Counts of waiting events by their time.
class BacklogCounts {
 public:
  // Waiting raw events with time < time_ns: they are the oldest ones. O(log n).
  virtual std::size_t before(std::int64_t time_ns) const noexcept ASAP_NONBLOCKING = 0;
  // An estimate of it in O(1), from a table of counts by age: off by less than the count of one
  // slot; events older than the table count in its oldest slot. It never decreases with time_ns and
  // never exceeds the count.
  virtual std::size_t about_before(std::int64_t time_ns) const noexcept ASAP_NONBLOCKING = 0;
  // The same for many times at once: counts[i] of newest_ns - i * step_ns. O(1) each.
  virtual void about_before_each(std::int64_t newest_ns, std::int64_t step_ns,
                                 std::span<std::size_t> counts) const noexcept ASAP_NONBLOCKING {
    for (std::size_t& count : counts) {
      count = about_before(newest_ns);
      newest_ns -= step_ns;
    }
  }

 protected:
  ~BacklogCounts() = default;
};

// The waiting events at the moment when a scheme is asked. count >= 1.
struct Backlog {
  std::size_t count;  // raw events
  std::int64_t now_ns;
  std::int64_t oldest_ns;          // time of the oldest waiting event
  std::int64_t previous_start_ns;  // start of the last package; kLongAgo before the first
  bool due;  // the oldest has waited for the latency bound, the ring is full or the source has
             // ended: the scheme takes something now
  const BacklogCounts& counts;

  std::int64_t age_ns() const noexcept { return now_ns - oldest_ns; }
};

// How the algorithm runs. whole: it takes a package in one call. anytime: the library owns the loop
// over its events and looks at the clock in between, so a package can end on time whatever it
// costs.
enum class Execution { whole, anytime };

// Wait (until a time or until so many events wait, whichever comes first), or take.
struct Decision {
  bool takes;
  std::int64_t until_ns = kNever;
  std::size_t until_count = std::numeric_limits<std::size_t>::max();
  std::size_t stale = 0;  // oldest raw events to throw away first
  std::size_t raw = 0;    // then the oldest raw events to take ...
  double gamma = 1.0;     // ... and the fraction of them to keep
  // Anytime execution: the package is to end budget_ns after its start, and `gamma` is only the
  // plan; it is expected to cost fixed_ns and event_ns per event, and no event more than
  // max_event_ns. Without a budget, and where the execution is `whole`, `gamma` holds.
  std::int64_t budget_ns = kNever;
  double fixed_ns = 0.0;
  double event_ns = 0.0;
  double max_event_ns = 0.0;

  static constexpr Decision wait_until(std::int64_t time_ns) noexcept {
    return {.takes = false, .until_ns = time_ns};
  }
  static constexpr Decision wait_for(std::size_t count) noexcept {
    return {.takes = false, .until_count = count};
  }
  static constexpr Decision take(std::size_t raw, double gamma = 1.0) noexcept {
    return {.takes = true, .raw = raw, .gamma = gamma};
  }
  // Throws the oldest events away; the scheme is asked again about the rest.
  static constexpr Decision drop(std::size_t stale) noexcept {
    return {.takes = true, .stale = stale};
  }
};

// What a package came to. size may be 0: all of `raw` were discarded and no algorithm ran.
struct Outcome {
  std::size_t size;            // events kept
  std::size_t raw;             // raw events taken; an anytime package may leave some to the next
  std::int64_t span_ns;        // newest minus oldest kept event
  std::int64_t start_ns;       // the package was taken
  std::int64_t processing_ns;  // until the algorithm had finished
  std::int64_t outage_ns =
      0;  // part of processing_ns in which the algorithm did not run, as far as it shows
  std::size_t first_size = 0;  // events of an anytime package's first part, if it had several ...
  std::int64_t first_ns = 0;   // ... and what that took, the fixed cost included

  std::int64_t work_ns() const noexcept { return processing_ns - outage_ns; }
};

// The largest package size that a parameter may ask for, events.
inline constexpr std::size_t kLargestSize = std::size_t{1} << 40;

class Scheme {
 public:
  virtual ~Scheme() = default;

  virtual Decision decide(const Backlog& backlog) noexcept ASAP_NONBLOCKING = 0;
  virtual void observe(const Outcome&) noexcept ASAP_NONBLOCKING {}
  // Back to the constructed state, before a run whose algorithm runs like that.
  virtual void reset(Execution) noexcept {}

  virtual std::string_view name() const noexcept = 0;
  virtual SchemeParameters parameters() const { return {}; }
  // The latency bound that the scheme plans with; 0 = it has none of its own. Any thread.
  virtual std::int64_t latency_bound_ns() const noexcept { return 0; }
  // Replaces the bound, from the next decision on. A scheme without a bound ignores it.
  virtual void set_latency_bound_ns(std::int64_t) noexcept {}

 private:
  friend class SchemeHold;

  // Whether a live run asks it. A copy is free.
  struct InUse {
    InUse() = default;
    InUse(const InUse&) noexcept {}
    InUse& operator=(const InUse&) noexcept { return *this; }

    std::atomic<bool> flag{false};
  } in_use_;
};

// What the schemes of this library that learn have in common: their law stands beside its source.
class LearningScheme : public Scheme {
 public:
  Decision decide(const Backlog& backlog) noexcept final;
  void observe(const Outcome& outcome) noexcept final;
  void reset(Execution execution) noexcept final;
  std::string_view name() const noexcept final;
  SchemeParameters parameters() const final;
  std::int64_t latency_bound_ns() const noexcept final;
  void set_latency_bound_ns(std::int64_t bound_ns) noexcept final;

 protected:
  explicit LearningScheme(std::unique_ptr<Scheme> law) noexcept : law_(std::move(law)) {}

  std::unique_ptr<Scheme> law_;
};

// A scheme of this library, for a program without exceptions: make_scheme<Asap2020>({...}).
template <class Made>
Result<Made> make_scheme(const typename Made::Config& config = {}) noexcept;

}  // namespace asap::inline v0_1
