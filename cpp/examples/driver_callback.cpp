// A driver's callback feeds a pipeline. Feed converts the driver's events, reports lost packets as
// differences of the driver's counter, and moves the arrival from the wall to the monotonic clock.
#include <asap/runner/pipeline.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <span>
#include <vector>

namespace {

using namespace std::chrono_literals;

struct DriverEvent {
  std::uint64_t t;  // us
  std::uint16_t x, y;
  bool on;
};

class Feed {
 public:
  explicit Feed(asap::Pipeline& pipeline) : pipeline_(pipeline) { events_.reserve(1 << 16); }

  // On the driver's thread; allocates only for a packet that is larger than any before.
  void operator()(std::span<const DriverEvent> packet, std::uint64_t lost_packets,
                  std::chrono::system_clock::time_point came) {
    if (lost_packets > lost_packets_) pipeline_.upstream_lost(1, lost_packets - lost_packets_);
    lost_packets_ = lost_packets;
    events_.clear();
    for (const auto& [t, x, y, on] : packet) {
      events_.push_back({.x = x, .y = y, .p = on, .t = static_cast<std::int64_t>(t)});
    }
    // Clamped, since the wall clock may have been set between the two readings.
    const auto age =
        std::clamp<std::chrono::nanoseconds>(std::chrono::system_clock::now() - came, 0ns, 1min);
    pipeline_.push(events_, std::chrono::steady_clock::now() - age);  // never waits
  }

 private:
  asap::Pipeline& pipeline_;
  std::vector<asap::Event> events_;
  std::uint64_t lost_packets_ = 0;
};
}  // namespace

int main() {
  asap::Pipeline pipeline{{.latency = 1s, .validator = {.width = 346, .height = 260}},
                          [](asap::EventSpan) { /* your algorithm */ }};
  Feed feed{pipeline};
  for (std::uint64_t k = 0; k < 100; ++k) {  // stands for the driver; it loses two packets
    const std::vector<DriverEvent> packet(1000, {.t = 1000 * k, .x = 5, .y = 7, .on = true});
    feed(packet, k < 50 ? 0 : 2, std::chrono::system_clock::now() - 2ms);
  }
  pipeline.stop();
  pipeline.join();
  const asap::PipelineStats stats = pipeline.stats();
  std::cout << stats.ledger.received << " events, " << stats.upstream_packets << " packets lost\n";
}
