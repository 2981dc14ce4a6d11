// ClipperAimd: a rival of the benchmark, the adaptive batching of the prediction server Clipper
// (Crankshaw et al., NSDI 2017): n = min(N, n_max) of the oldest; after a package that took no more
// than L/2, n_max grows by 50 if the package was full; after a longer one it shrinks by a tenth. It
// never drops. A baseline of an experiment, not a product. O(1) per package.
#pragma once

#include "study/rival.hpp"

namespace asap {

class ClipperAimd final : public Rival {
 public:
  explicit ClipperAimd(double latency_ms);

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "clipper_aimd"; }

 private:
  std::size_t whole_limit() const noexcept { return static_cast<std::size_t>(limit_); }

  double limit_;  // n_max
};

}  // namespace asap
