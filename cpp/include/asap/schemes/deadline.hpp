// Deadline: as many events as possible within the latency bound L, counted from their arrival
// (live) or their timestamp (a recording), and none later. A backlog that fits into the bound is
// taken whole. Otherwise the scheme plays a dozen plans forward on the backlog and takes the best
// (notebooks/theory.md, section 6). A plan is a package of some length T: it drops events older
// than L - T, thins the older part of the rest to the number that it can finish, and leaves the
// newest events in the ring. Its value is the work finished in time if arrivals stop and, in a
// rush, the work of such packages if they go on, less the price of a gap.
//
// There is no rate estimate and no integrator in the loop, so nothing lags. Called on the
// consumer's thread, once or twice per package. 32 counts by age and one exact one, no allocation.
// Where the bound is below what the algorithm needs at all, it plans with 2.5 fixed costs.
//
//   Deadline scheme{{.prefer = Prefer::continuity}};
//   Pipeline pipeline{scheme, {.latency = 10ms}};  // without a scheme: Deadline
#pragma once

#include <cstddef>
#include <string_view>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

// What matters more in overload where the two differ: the number of processed events, or that no
// long stretch of time (a gap) goes by without one.
enum class Prefer {
  balanced,    // a gap has a price; python/laboratory/pages/bounds.md has the gaps
  events,      // a quarter of that price
  continuity,  // short gaps
};

// As it is written in Python and on the command line.
std::string_view name_of(Prefer prefer) noexcept;
// Throws std::invalid_argument for any other name.
Prefer prefer_of(std::string_view name);

struct DeadlineConfig {
  std::chrono::nanoseconds latency = kDefaultLatency;  // L, the one number that a user must know
  double overhead = 0.5;  // permitted share of fixed costs in the processor, 0 = any
  std::chrono::nanoseconds min_interval{};  // shortest time between package starts
  double first_alpha_us = 50.0;             // cost of a package before one has been seen
  double first_beta_ns = 100.0;             // cost of an event, likewise
  Prefer prefer = Prefer::balanced;

  static constexpr std::tuple kParameters{
      NamedField{"latency_ms", &DeadlineConfig::latency},
      NamedField{"overhead", &DeadlineConfig::overhead},
      NamedField{"min_interval_ms", &DeadlineConfig::min_interval},
      NamedField{"first_alpha_us", &DeadlineConfig::first_alpha_us},
      NamedField{"first_beta_ns", &DeadlineConfig::first_beta_ns},
      NamedField{"prefer", &DeadlineConfig::prefer},
  };
};

class Deadline final : public LearningScheme {
 public:
  using Config = DeadlineConfig;

  explicit Deadline(Config config = {});

  // What a package costs, as far as it is known.
  double alpha_ns() const noexcept;
  double beta_ns() const noexcept;

  // What the constructor takes from the heap.
  static std::size_t memory_bytes() noexcept;
};

// The default scheme, for a program without exceptions.
inline Result<Deadline> make_scheme(const DeadlineConfig& config = {}) noexcept {
  return make_scheme<Deadline>(config);
}

}  // namespace asap::inline v0_1
