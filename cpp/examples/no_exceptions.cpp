// A program without exceptions and RTTI, as on-board code often is: built with -fno-exceptions
// -fno-rtti. What cannot be made is a message. All memory is there before the first event.
#include <asap/algorithms/cluster_tracker.hpp>
#include <asap/runner/pipeline.hpp>
#include <asap/synthetic/streams.hpp>

#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

using namespace std::chrono_literals;

namespace {

int refuse(const std::string& message) {
  std::printf("%s\n", message.c_str());
  return 1;
}

}  // namespace

int main() {
  const auto tracker = asap::make_tracker({.width = 346, .height = 260});
  if (!tracker) return refuse(tracker.message());

  const asap::RunConfig config{
      .latency = 10ms,     // -5 would print: latency = -5 ms: must be between 0.01 and 1e7 ms
      .capacity = 65'536,  // events of 16 bytes that may wait
      .log_rows = 0,       // totals, without a row per package
      .max_copied = 16'384,
      .prefault = true,  // no page is missing when events come
  };
  const auto pipeline =
      asap::make_pipeline(config, [&](asap::EventSpan events) { tracker->process(events); });
  if (!pipeline) return refuse(pipeline.message());

  asap::FlightOverChairs camera{{.duration = std::chrono::milliseconds(300)}};  // or a driver
  for (auto events = camera.next(); !events.empty(); events = camera.next()) {
    pipeline->push(events);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  pipeline->stop();
  pipeline->join();
  std::printf("%zu bytes, all taken before the first event. %s\n", asap::memory_bytes(config),
              pipeline->ledger().balanced() ? "Every event is accounted for." : "Events are lost.");
}
