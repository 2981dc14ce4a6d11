// FixedSize: packages of n events, gamma 1. The n oldest are taken when n wait, so a backlog is cut
// where it would have been cut on arrival. Flush: when the oldest event has waited for the latency
// bound, what waits is taken, however few. What most tools do today.
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap {

struct FixedSizeConfig {
  std::size_t size = 1000;  // events

  static constexpr std::tuple kParameters{
      NamedField{"size", &FixedSizeConfig::size},
  };
};

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

}  // namespace asap
