// A scheme of your own: one package per period, thinned to what the algorithm can process within
// a period. It works in virtual time, as here, and in a live pipeline.
#include <asap/runner/simulator.hpp>
#include <asap/synthetic/streams.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <string_view>

namespace {

class Periodic final : public asap::Scheme {
 public:
  explicit Periodic(std::int64_t period_us) : period_ns_(1000 * period_us) {}

  // Asked when the algorithm is idle and events wait. When one is due, something must be taken.
  asap::Decision decide(const asap::Backlog& backlog) noexcept override {
    const std::int64_t start_ns = backlog.previous_start_ns + period_ns_;
    if (backlog.now_ns < start_ns && !backlog.due) return asap::Decision::wait_until(start_ns);
    const double affordable = static_cast<double>(period_ns_) / event_ns_;
    const double gamma = std::min(1.0, affordable / static_cast<double>(backlog.count));
    return asap::Decision::take(backlog.count, gamma);
  }

  // Told what the package cost.
  void observe(const asap::Outcome& outcome) noexcept override {
    if (outcome.size == 0) return;
    const auto processing_ns = static_cast<double>(outcome.processing_ns);
    event_ns_ += 0.3 * (processing_ns / static_cast<double>(outcome.size) - event_ns_);
  }

  void reset(asap::Execution) noexcept override { event_ns_ = kFirstEvent_ns; }
  std::string_view name() const noexcept override { return "periodic"; }

 private:
  static constexpr double kFirstEvent_ns = 100.0;

  const std::int64_t period_ns_;
  double event_ns_ = kFirstEvent_ns;  // processing time per event, smoothed
};

}  // namespace

int main() {
  using namespace std::chrono_literals;
  asap::ShakenPattern scene{{.duration = 1s}};  // from 0.1 to 13 Mev/s
  Periodic scheme{4'000};
  const asap::LinearCost cost{{.alpha_us = 100, .beta_ns = 300}};  // at most 3.3 Mev/s
  asap::Simulator simulator{scheme, cost, {.latency = 10ms}};
  simulator.run(scene);

  const asap::Ledger ledger = simulator.ledger();
  const asap::LatencyHistogram& latency = simulator.stats().latency;
  std::cout << scheme.name() << ": " << 100 * ledger.delivered / ledger.received
            << " % of the events kept, the latest processed after "
            << static_cast<double>(latency.max_ns()) * 1e-6 << " ms\n";
}
