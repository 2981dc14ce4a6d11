// FixedTime: one package per period of event time, gamma 1. A package holds the events before the
// next multiple of the period, so a backlog is cut where it would have been cut on arrival; periods
// without events give no package. Flush: when the oldest event has waited for the latency bound,
// the part of the period that has arrived is taken.
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap {

struct FixedTimeConfig {
  double period_ms = 1.0;

  static constexpr std::tuple kParameters{
      NamedField{"period_ms", &FixedTimeConfig::period_ms},
  };
};

class FixedTime final : public Scheme {
 public:
  using Config = FixedTimeConfig;

  explicit FixedTime(Config config = {});

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "fixed_time"; }
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  const FixedTimeConfig config_;
  const std::int64_t period_ns_;
};

}  // namespace asap
