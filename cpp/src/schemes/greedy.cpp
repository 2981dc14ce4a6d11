#include "asap/schemes/greedy.hpp"

#include <algorithm>

#include "core/check.hpp"
#include "schemes/bounded_scheme.hpp"

namespace asap::inline v0_1 {
namespace {

class GreedyLaw final : public Scheme {
 public:
  explicit GreedyLaw(GreedyConfig config);

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "greedy"; }
  // Without a cap there is no number to tell.
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  const GreedyConfig config_;
  CostModel cost_;
};

GreedyLaw::GreedyLaw(GreedyConfig config) : config_(config) {
  const double efficiency = config.efficiency.value_or(0.5);
  require(efficiency > 0 && efficiency < 1, "efficiency", efficiency,
          "must lie between 0 and 1, or be left out for no cap");
}

Decision GreedyLaw::decide(const Backlog& backlog) noexcept {
  if (!config_.efficiency) return Decision::take(backlog.count);
  const double eta = *config_.efficiency;
  const double cap = eta / (1.0 - eta) * cost_.alpha_ns() / cost_.beta_ns();
  if (cap >= static_cast<double>(backlog.count)) return Decision::take(backlog.count);
  return Decision::take(std::max<std::size_t>(static_cast<std::size_t>(cap), 1));
}

void GreedyLaw::observe(const Outcome& outcome) noexcept { cost_.update(outcome); }

void GreedyLaw::reset(Execution) noexcept { cost_.reset(); }

}  // namespace

Greedy::Greedy(Config config) : LearningScheme(std::make_unique<GreedyLaw>(config)) {}

}  // namespace asap::inline v0_1
