// FixedSize, FixedTime, SingleEvent: schemes that cut the stream without a look at the algorithm,
// as most tools do today. gamma is 1. Called on the consumer's thread, once per package; no
// allocation.
//
//   FixedTime scheme{{.period = 10ms}};
//   Replay replay{scheme, {.speed = 1.0}, {}};
#pragma once

#include <chrono>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

struct FixedSizeConfig {
  std::size_t size = 1000;  // events

  static constexpr std::tuple kParameters{
      NamedField{"size", &FixedSizeConfig::size},
  };
};

// Packages of n events. The n oldest are taken when n wait, so a backlog is cut where it would have
// been cut on arrival. Flush: when the oldest event has waited for the latency bound, what waits is
// taken, however few.
class FixedSize final : public Scheme {
 public:
  using Config = FixedSizeConfig;

  explicit FixedSize(Config config = {});

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "fixed_size"; }
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  const FixedSizeConfig config_;
};

struct FixedTimeConfig {
  std::chrono::nanoseconds period = std::chrono::milliseconds(1);

  static constexpr std::tuple kParameters{
      NamedField{"period_ms", &FixedTimeConfig::period},
  };
};

// One package per period of event time. A package holds the events before the next multiple of the
// period, so a backlog is cut where it would have been cut on arrival; periods without events give
// no package. Flush: when the oldest event has waited for the latency bound, the part of the period
// that has arrived is taken.
class FixedTime final : public Scheme {
 public:
  using Config = FixedTimeConfig;

  explicit FixedTime(Config config = {});

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "fixed_time"; }
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  const FixedTimeConfig config_;
};

struct SingleEventConfig {};

// Every event is a package of its own. The shortest wait there is, and the first to overflow: it is
// stable only below 1 / (alpha + beta) events per second.
class SingleEvent final : public Scheme {
 public:
  using Config = SingleEventConfig;

  explicit SingleEvent(Config = {}) noexcept {}

  Decision decide(const Backlog&) noexcept override { return Decision::take(1); }
  std::string_view name() const noexcept override { return "single_event"; }
};

}  // namespace asap::inline v0_1
