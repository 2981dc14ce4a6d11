// Setup: the valid configuration that a seed draws: bound, ring, execution, scheme with its
// parameters, door, the consumer's cost and the stream's rate. Everything in it is printed when a
// run fails.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "asap/filter/validator.hpp"
#include "asap/schemes/scheme.hpp"
#include "draw.hpp"

namespace asap::simulation {

enum class Kind {
  fixed_size,
  fixed_time,
  single_event,
  greedy,
  asap2020,
  asap2022,
  deadline,
  dead_beat,
  hostile,  // a user's scheme that answers nonsense; a fault, never drawn as a configuration
};

// What the checks need to know of a scheme.
struct SchemeSetup {
  Kind kind = Kind::fixed_size;
  std::size_t size = 0;        // fixed_size; least size of asap2020
  std::size_t max_size = 0;    // largest size of asap2020 and asap2022
  std::int64_t period_ns = 0;  // fixed_time
  double efficiency = 0;       // greedy; 0: none
  double min_gamma = 0;        // never below
  std::uint64_t key = 0;       // of the parameters that no check looks at
};

struct Setup {
  std::uint64_t seed = 0;
  bool by_arrival = false;
  Execution execution = Execution::whole;
  bool flush = true;
  bool fixed_cost_first = true;  // else it is part of the first stratum's cost
  bool asks_stratum = true;      // else the caller has processed package.events himself
  std::int64_t latency_ns = 0;
  std::size_t capacity = 0;
  std::uint64_t filter_seed = 0;
  ValidatorConfig door{};
  SchemeSetup scheme{};
  double alpha_ns = 0;
  double beta_ns = 0;
  double cost_noise = 0;
  double gap_ns = 0;  // mean, between events
  std::int64_t base_us = 0;
  std::size_t events = 0;
  std::size_t longest_packet = 1;
  std::int64_t lag_ns = 0;  // longest between a look at the clock and what follows, and to wake up

  // Where faults have ended, and where it is judged whether the loop has recovered.
  std::size_t faults_end() const noexcept { return events * 2 / 5; }
  std::size_t judged_from() const noexcept { return events * 4 / 5; }
  double load() const noexcept { return beta_ns / gap_ns; }
  bool keeps_a_bound() const noexcept {
    return scheme.kind == Kind::deadline || scheme.kind == Kind::dead_beat;
  }
};

Setup draw_setup(std::uint64_t seed);
SchemeSetup draw_scheme(Draw& draw, const Setup& setup, std::size_t kinds);
std::unique_ptr<Scheme> make_scheme(const Setup& setup);
// What a scheme that keeps a bound believes that a package costs.
struct Belief {
  double alpha_ns = 0;
  double beta_ns = 0;
};
Belief belief(const Setup& setup, const Scheme& scheme);
std::string text(const Setup& setup);

}  // namespace asap::simulation
