// LiveSetup: what a live run has beyond a Setup: which events give way, a filter in front, the
// consumer's loop, and what other threads ask for while it runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "asap/runner/run_config.hpp"
#include "setup.hpp"

namespace asap::simulation {

struct LiveSetup {
  WhenFull when_full = WhenFull::thin;  // block is not drawn: its producer sleeps, too
  double passing = 1.0;                 // share that a filter in front lets pass; 1: there is none
  std::uint64_t filter_key = 0;
  bool own_loop = false;         // `next` in a loop of the caller's own, else `run`
  std::int64_t patience_ns = 0;  // of it
  double asks = 0.0;             // chance, per packet, that somebody asks for something
  std::size_t abandoned_at = 0;  // events of the source; may be beyond the end

  bool passes(const Event& event) const noexcept;
};

// Makes of the setup one of a live run.
LiveSetup draw_live(Setup& setup);
RunConfig run_config(const Setup& setup, FrontFilter before, WhenFull when_full);
std::string text(const LiveSetup& live);

}  // namespace asap::simulation
