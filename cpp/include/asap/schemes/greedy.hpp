// Greedy: when the algorithm is free it gets all that waits, gamma 1. Without parameters, and
// optimal for the latency as long as the algorithm keeps up; no bound on anything as soon as it
// does not.
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap {

class Greedy final : public Scheme {
 public:
  Decision decide(const Backlog& backlog) noexcept override {
    return Decision::take(backlog.count);
  }
  std::string_view name() const noexcept override { return "greedy"; }
};

}  // namespace asap
