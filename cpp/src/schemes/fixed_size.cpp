#include "asap/schemes/fixed_size.hpp"

#include <algorithm>

#include "asap/core/check.hpp"

namespace asap {

FixedSize::FixedSize(Config config) : config_(config) {
  require(config.size >= 1 && config.size <= kLargestSize, "size", config.size,
          "must be between 1 and 2^40 events");
}

Decision FixedSize::decide(const Backlog& backlog) noexcept {
  if (backlog.count < config_.size && !backlog.due) return Decision::wait_for(config_.size);
  return Decision::take(std::min(backlog.count, config_.size));
}

}  // namespace asap
