// A producer at memory speed: every counter exact, memory flat. With a summing algorithm where the
// newest are dropped, and with a slow one where the ring thins.
#include <atomic>
#include <string>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/deadline.hpp"
#include "camera.hpp"
#include "measure.hpp"
#include "parts.hpp"
#include "study/realtime.hpp"

namespace asap::soak {
namespace {

using namespace std::chrono_literals;

void saturated(const std::string& name, WhenFull when_full, double beta_ns, double seconds,
               std::uint64_t seed) {
  constexpr std::size_t kPacket = 4096;
  BusyWait work({.alpha_us = 0, .beta_ns = beta_ns});
  Deadline scheme({.latency = 10ms});
  Pipeline pipeline(scheme, {.capacity = 65'536, .when_full = when_full});
  std::uint64_t seen = 0;
  std::int64_t sum = 0;
  std::thread consumer([&] {
    pipeline.run([&](EventSpan events) {
      for (const Event& event : events) sum += event.x;
      seen += events.size();
      if (beta_ns > 0) work.process(events);
    });
  });
  MemoryWatch memory(seconds);
  std::uint64_t sent = 0;
  double cpu_s = 0;
  const auto start = Steady::now();
  std::atomic<bool> done = false;
  std::thread producer([&] {
    Camera camera(kPacket, seed);
    while (seconds_since(start) < seconds) {
      for (int i = 0; i < 100; ++i, sent += kPacket) pipeline.push(camera.packet(kPacket, 14));
    }
    cpu_s = thread_cpu_s();
    done = true;
  });
  while (!done) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    memory.look();
  }
  const double elapsed_s = seconds_since(start);
  producer.join();
  pipeline.stop();
  consumer.join();

  const Ledger ledger = pipeline.ledger();
  const bool exact = ledger.balanced() && ledger.received == sent && ledger.delivered == seen &&
                     ledger.pending == 0 && ledger.rejected == 0 && sum > 0;
  figure(name + "_events", sent);
  figure(name + "_wrong", !exact);
  figure(name + "_mev_per_s", 1e-6 * static_cast<double>(sent) / elapsed_s);
  figure(name + "_mev_per_cpu_s", 1e-6 * static_cast<double>(sent) / cpu_s);
  figure(name + "_memory_growth_mib", memory.growth());
}

}  // namespace

void saturation(double seconds, std::uint64_t seed) {
  saturated("saturation_newest", WhenFull::keep_oldest, 0, seconds / 2, seed);
  saturated("saturation_thin", WhenFull::thin, 100, seconds / 2, seed);
}

}  // namespace asap::soak
