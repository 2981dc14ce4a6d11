// Stands in for asap/core/event.hpp under the model checker, which sees this Event's reads and
// writes: a ring that publishes too early is a data race, also on a machine that would forgive it.
#pragma once

#include <cstddef>
#include <span>

#include "atomics.hpp"

namespace asap {

struct Event {
  rl::var<unsigned> number;

  Event() = default;
  explicit Event(unsigned value) { number($) = value; }
  Event(const Event& other) { *this = other; }
  Event& operator=(const Event& other) {
    const unsigned value = other.number($);
    number($) = value;
    return *this;
  }
};

using EventSpan = std::span<const Event>;

}  // namespace asap
