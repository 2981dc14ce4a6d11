// Memory fixed by the configuration: a pipeline takes all of it in its constructor. This program
// counts allocations while far more events come than the ring holds.
#include <asap/runner/pipeline.hpp>
#include <asap/synthetic/streams.hpp>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <new>

using namespace std::chrono_literals;

namespace {

std::atomic<std::uint64_t> allocations{0};  // of all threads
std::atomic<std::uint64_t> bytes{0};

}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  bytes += size;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

int main() {
  asap::FlightOverChairs camera{{.duration = std::chrono::seconds(1)}};
  const asap::RunConfig config{
      .latency = 10ms,
      .capacity = 16'384,                 // events of 16 bytes that may wait in the ring
      .when_full = asap::WhenFull::thin,  // a random part of the new events gives way
  };
  const std::uint64_t bytes_before = bytes;
  std::uint64_t brighter = 0;
  asap::Pipeline pipeline{config, [&](asap::EventSpan events) {
                            for (const asap::Event& event : events) brighter += event.p == 1;
                          }};
  std::cout << "The pipeline takes " << (bytes - bytes_before) / 1024 << " KiB.\n";

  const std::uint64_t allocations_before = allocations;
  for (auto events = camera.next(); !events.empty(); events = camera.next()) {
    pipeline.push(events);  // as fast as they are made
  }
  pipeline.stop();
  pipeline.join();
  const std::uint64_t allocations_in_the_run = allocations - allocations_before;

  const asap::PipelineStats stats = pipeline.stats();
  std::cout << stats.ledger.received << " events came, at most " << stats.max_waiting << " waited, "
            << brighter << " of the delivered ones are ON: " << allocations_in_the_run
            << " allocations.\n";
}
