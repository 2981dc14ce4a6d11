// Any scheme of any configuration that the input spells, good or bad; and any simulated cost.
#pragma once

#include <memory>
#include <utility>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "bytes.hpp"

namespace asap::fuzz {

using namespace std::chrono_literals;

inline Asap2020Config asap2020_config(Bytes& bytes) {
  Asap2020Config config;
  config.rate_bound = bytes.real(1.0, 1e9);
  config.epsilon = bytes.real(0.0, 1.0);
  if (bytes.flag()) config.max_size = bytes.count(std::size_t{1} << 40);
  if (bytes.flag()) config.first_size = bytes.count(config.max_size | 1);
  if (bytes.flag()) config.min_size = bytes.count(config.first_size | 1);
  return config;
}

inline Asap2022Config asap2022_config(Bytes& bytes) {
  Asap2022Config config;
  if (bytes.flag()) config.max_processing = bytes.time(1ns, 1'000'000s);
  if (bytes.flag()) config.min_processing = bytes.time(1ns, config.max_processing);
  if (bytes.flag()) config.max_size = bytes.count(std::size_t{1} << 40);
  if (bytes.flag()) config.min_size = bytes.count(config.max_size | 1);
  if (bytes.flag()) config.kappa = bytes.real(1e-6, 1e6);
  if (bytes.flag()) config.max_gamma = bytes.real(0.0, 1.0);
  if (bytes.flag()) config.min_gamma = bytes.real(0.0, config.max_gamma);
  if (bytes.flag()) config.first_size = bytes.count(std::size_t{1} << 40);
  return config;
}

inline DeadlineConfig deadline_config(Bytes& bytes) {
  DeadlineConfig config;
  if (bytes.flag()) config.latency = bytes.time(10us, 10'000s);
  if (bytes.flag()) config.overhead = bytes.real(0.0, 1.0);
  if (bytes.flag()) config.min_interval = bytes.time(0s, 10'000s);
  if (bytes.flag()) config.prefer = static_cast<Prefer>(bytes.take<std::uint8_t>() % 3);
  if (bytes.flag()) config.first_alpha_us = bytes.real(0.001, 1e9);
  if (bytes.flag()) config.first_beta_ns = bytes.real(0.001, 1e9);
  return config;
}

inline DeadBeatConfig dead_beat_config(Bytes& bytes) {
  DeadBeatConfig config;
  if (bytes.flag()) config.latency = bytes.time(10us, 10'000s);
  if (bytes.flag()) config.knee = bytes.real(1.0, 1e6);
  if (bytes.flag()) config.overhead = bytes.real(0.0, 1.0);
  if (bytes.flag()) config.min_interval = bytes.time(0s, 10'000s);
  return config;
}

// Throws std::invalid_argument where the configuration is none.
inline std::unique_ptr<Scheme> any_scheme(Bytes& bytes) {
  switch (bytes.take<std::uint8_t>() % 9) {
    case 0:
      return std::make_unique<Asap2020>(asap2020_config(bytes));
    case 1:
      return std::make_unique<Asap2022>(asap2022_config(bytes));
    case 2:
      return std::make_unique<DeadBeat>(dead_beat_config(bytes));
    case 3:
      return std::make_unique<FixedSize>(FixedSizeConfig{.size = bytes.count(1 << 20)});
    case 4:
      return std::make_unique<FixedTime>(FixedTimeConfig{.period = bytes.time(1us, 1'000'000s)});
    case 5:
      return std::make_unique<Greedy>(GreedyConfig{.efficiency = bytes.real(0.0, 1.0)});
    case 6:
      return std::make_unique<Greedy>();
    case 7:
      return std::make_unique<SingleEvent>();
    default:
      return std::make_unique<Deadline>(deadline_config(bytes));
  }
}

// Throws std::invalid_argument likewise.
inline LinearCost any_cost(Bytes& bytes) {
  LinearCostConfig config{.alpha_us = bytes.real(0.0, 1e9),
                          .beta_ns = bytes.real(0.0, 1e9),
                          .noise = bytes.flag() ? bytes.real(0.0, 5.0) : 0.0,
                          .seed = bytes.take<std::uint16_t>()};
  for (std::size_t i = bytes.below(4); i > 0; --i) config.drift.push_back(bytes.real(0.0, 1e6));
  for (std::size_t i = bytes.below(4); i > 0; --i) {
    const auto begin_ns = bytes.flag() ? bytes.take<std::int64_t>() : bytes.take<std::int32_t>();
    const auto end_ns = bytes.flag() ? bytes.take<std::int64_t>() : begin_ns / 2 + 1'000'000'000;
    config.outages.push_back({begin_ns, end_ns});
  }
  return LinearCost(std::move(config));
}

}  // namespace asap::fuzz
