// More cores before fewer events: a corner detector on two threads. For the pipeline it is an
// algorithm like any other, whose cost it learns; its labels are those of one instance, to the bit.
#include <asap/algorithms/corner_detector.hpp>
#include <asap/runner/pipeline.hpp>
#include <asap/runner/tiled.hpp>
#include <asap/synthetic/streams.hpp>

#include <chrono>
#include <cstdint>
#include <iostream>
#include <thread>
#include <vector>

int main() {
  using namespace std::chrono_literals;
  const asap::EHarrisConfig config{.width = 346, .height = 260};
  asap::Tiled<asap::EHarris> detector{config, {.threads = 2}};
  asap::EHarris one{config};  // to compare

  std::size_t corners = 0;
  bool same = true;
  std::vector<std::uint8_t> labels, labels_of_one;
  const auto process = [&](asap::EventSpan events) {
    labels.resize(events.size());
    labels_of_one.resize(events.size());
    detector.process(events, std::span(labels));
    one.process(events, std::span(labels_of_one));
    same = same && labels == labels_of_one;
    for (const std::uint8_t label : labels) corners += label;
  };
  asap::Pipeline pipeline{{.latency = 10ms}, process};

  asap::FlightOverChairs camera{{.duration = std::chrono::milliseconds(500)}};  // or a driver
  const auto start = std::chrono::steady_clock::now();
  for (auto events = camera.next(); !events.empty(); events = camera.next()) {
    std::this_thread::sleep_until(start + std::chrono::microseconds(events.back().t));
    pipeline.push(events);
  }
  pipeline.stop();
  pipeline.join();
  std::cout << corners << " corners, " << (same ? "the same" : "other ones") << " on one thread\n";
}
