#include "study/clipper_aimd.hpp"

#include <algorithm>

namespace asap {
namespace {

constexpr double kStep = 50;  // events; also the first limit
constexpr double kBackOff = 0.9;

}  // namespace

ClipperAimd::ClipperAimd(double latency_ms) : Rival(latency_ms), limit_(kStep) {}

Decision ClipperAimd::decide(const Backlog& backlog) noexcept {
  return Decision::take(std::min(backlog.count, whole_limit()));
}

void ClipperAimd::observe(const Outcome& outcome) noexcept {
  if (outcome.processing_ns > latency_ns_ / 2) {
    limit_ = std::max(1.0, kBackOff * limit_);
  } else if (outcome.size >= whole_limit()) {
    limit_ += kStep;
  }
}

void ClipperAimd::reset(Execution) noexcept { limit_ = kStep; }

}  // namespace asap
