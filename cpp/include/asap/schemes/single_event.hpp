// SingleEvent: every event is a package of its own, gamma 1. The shortest wait there is, and the
// first to overflow: it is stable only below 1 / (alpha + beta) events per second.
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap {

class SingleEvent final : public Scheme {
 public:
  Decision decide(const Backlog&) noexcept override { return Decision::take(1); }
  std::string_view name() const noexcept override { return "single_event"; }
};

}  // namespace asap
