// Asap2020: the scheme of the paper (Tapia, Gomez Eguiluz, Martinez-de Dios, Ollero, ICRA workshop
// 2020). The paper gives no formulas; this is one faithful reading, in pull form.
//
//   size    the processing time H shall equal the span, less a margin epsilon:
//           n <- n clip(H / ((1 - epsilon) span), 1/2, 2);  2n where the span is 0;  then clipped
//           to [min_size, max_size]
//   gamma   R = n / span is the thinned rate of the package.  R > a: gamma <- gamma a / R, at
//           least 0.02;  else gamma <- min(1, 1.02 gamma)
//
// n counts kept events: n / gamma raw ones are taken, the oldest first, the rest waits. R is noisy
// in a package of a few events: give a fast algorithm, which gets small packages, a min_size of 20
// or more, or gamma falls now and then without need. Flush: when the oldest event has waited for
// the latency bound, all that waits is taken. On the consumer's thread, O(1), no allocation.
//
//   Asap2020 scheme{{.rate_bound = 5e6}};
//   Pipeline pipeline{scheme, {.latency = 10ms}};
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

struct Asap2020Config {
  double rate_bound = 5e6;  // a, events per second after the gamma filter
  double epsilon = 0.05;    // margin of real time, 0 <= epsilon < 1
  std::size_t first_size = 1000;
  std::size_t max_size = 50'000;
  std::size_t min_size = 1;

  static constexpr std::tuple kParameters{
      NamedField{"rate_bound", &Asap2020Config::rate_bound},
      NamedField{"epsilon", &Asap2020Config::epsilon},
      NamedField{"first_size", &Asap2020Config::first_size},
      NamedField{"max_size", &Asap2020Config::max_size},
      NamedField{"min_size", &Asap2020Config::min_size},
  };
};

class Asap2020 final : public Scheme {
 public:
  using Config = Asap2020Config;

  explicit Asap2020(Config config = {});

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "asap2020"; }
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  void adapt_size(const Outcome& outcome) noexcept;
  void adapt_gamma(const Outcome& outcome) noexcept;

  const Asap2020Config config_;
  double size_;  // n, a whole number
  double gamma_;
};

}  // namespace asap::inline v0_1
