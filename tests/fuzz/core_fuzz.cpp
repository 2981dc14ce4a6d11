// The core in one piece, in virtual time: any events through validator, ring, gamma filter and
// packager under any scheme. The ledger is balanced after every chunk; what the algorithm gets is
// ordered, in frame, and what the log says; how the events are cut makes no difference.
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "any_scheme.hpp"
#include "asap/runner/simulator.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

struct Algorithm {
  int width;
  int height;
  std::int64_t last_us = -Validator::kMaxStamp_us;
  std::uint64_t packages = 0;
  std::uint64_t size = 0;

  void operator()(const Package& package) {
    fuzz::check(!package.events.empty() && package.index == packages++);
    fuzz::check(package.gamma > 0.0 && package.gamma <= 1.0);
    for (const Event& event : package.events) {
      fuzz::check(event.t >= last_us && event.x < width && event.y < height && event.p >> 1 == 0);
      last_us = event.t;
    }
    size += package.events.size();
  }
};

void check_row(const PackageRow& row) {
  for (const double value : {row.start_us, row.processing_us, row.gamma, row.event_rate, row.rate,
                             row.margin_us, row.latency_max_us}) {
    fuzz::check(std::isfinite(value));
  }
  fuzz::check(row.size >= 1 && row.offered >= row.size && row.processing_us > 0);
  fuzz::check(row.latency_max_us >= 0 && row.event_rate >= 0 && row.rate > 0);
}

Ledger simulate(Scheme& scheme, const LinearCost& cost, const RunConfig& config, EventSpan events,
                std::size_t piece) {
  Algorithm algorithm{config.validator.width, config.validator.height};
  Simulator simulator(scheme, cost, config, std::ref(algorithm));
  try {
    for (std::size_t at = 0; at < events.size(); at += piece) {
      simulator.feed(events.subspan(at, std::min(piece, events.size() - at)));
      fuzz::check(simulator.ledger().balanced());
    }
  } catch (const std::invalid_argument&) {
    fuzz::check(config.validator.on_bad == OnBad::raise && simulator.stats().rejected.total() == 1);
  }
  fuzz::check(simulator.ledger().balanced());
  simulator.finish();
  const Ledger ledger = simulator.ledger();
  fuzz::check(ledger.balanced() && ledger.pending == 0 && ledger.delivered == algorithm.size);
  const RunLog& log = simulator.log();
  fuzz::check(log.size() == algorithm.packages);
  for (std::size_t i = 0; i < log.size(); ++i) check_row(log[i]);
  return ledger;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  try {
    const auto scheme = fuzz::any_scheme(bytes);
    const LinearCost cost = fuzz::any_cost(bytes);
    RunConfig config{
        .capacity = 1 + bytes.below(1 << (1 + bytes.below(11))),
        .seed = bytes.take<std::uint8_t>(),
        .validator = {.width = 1 + static_cast<int>(bytes.below(400)),
                      .height = 1 + static_cast<int>(bytes.below(400)),
                      .on_bad = static_cast<OnBad>(bytes.below(3)),
                      .reorder_tolerance = std::chrono::microseconds(bytes.take<std::uint8_t>())},
        .execution = bytes.flag() ? Execution::anytime : Execution::whole};
    if (bytes.below(4) == 0)
      config.latency = bytes.time(std::chrono::microseconds(10), std::chrono::seconds(10'000));
    const std::size_t piece = 1 + bytes.below(600);
    const auto events = bytes.below(4) == 0 ? bytes.events(1000) : bytes.stream(1500);
    const Ledger ledger = simulate(*scheme, cost, config, events, events.size() + 1);
    fuzz::check(ledger == simulate(*scheme, cost, config, events, piece));
  } catch (const std::invalid_argument& refused) {
    fuzz::check(std::string(refused.what()).find(" = ") != std::string::npos);
  }
  return 0;
}
