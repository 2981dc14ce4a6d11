// The hot path under RealtimeSanitizer: inside a function that is marked nonblocking it ends the
// program at an allocation, a lock, a sleep or any other system call, wherever that is called.
//
//   realtime                     push beside a worker that sleeps; every scheme, whole and anytime
//   realtime new|lock|sleep      does that on the hot path: has to be caught
//
// tests/realtime/run builds it with clang and the library as it is.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "packager/packager.hpp"

namespace {

using asap::Event, asap::EventSpan, asap::Packager;

constexpr std::size_t kBatch = 1000;
constexpr std::int64_t kStep_us = 1000;

// ---- what must not block

bool push(asap::Pipeline& pipeline, EventSpan events) noexcept [[clang::nonblocking]] {
  return pipeline.push(events);
}

// Decides, filters, packs, hands out and feeds back what waits; virtual time, 300 ns per event.
std::size_t consume(Packager& packager, std::int64_t& now_ns) noexcept [[clang::nonblocking]] {
  std::size_t delivered = 0;
  for (auto next = packager.next(now_ns); next.step == Packager::Step::package;
       next = packager.next(now_ns)) {
    EventSpan part = packager.stratum(next.package, now_ns);
    for (; !part.empty(); part = packager.stratum(next.package, now_ns)) {
      delivered += part.size();
      now_ns += 300 * static_cast<std::int64_t>(part.size());
    }
    now_ns += 50'000;
    packager.complete(next.package, now_ns);
  }
  return delivered;
}

void plant(std::string_view what) noexcept [[clang::nonblocking]] {
  static std::mutex mutex;
  [[maybe_unused]] static volatile char* kept = nullptr;
  if (what == "new") kept = new char[100];
  if (what == "lock") mutex.lock();
  if (what == "sleep") std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

// ---- the rest of the program

// So many events, one each `gap_us`, from t_us on.
void fill(std::vector<Event>& events, std::int64_t& t_us) {
  for (Event& event : events) event = {1, 2, 1, t_us += kStep_us / static_cast<int>(kBatch)};
}

bool pipeline() {
  const auto pipeline = asap::make_pipeline(
      {.latency = std::chrono::seconds(1), .capacity = 16'384, .validator = {.width = 346}},
      [](EventSpan) {});
  if (!pipeline) return false;
  std::vector<Event> events(kBatch);
  std::int64_t t_us = 0;
  for (int batch = 0; batch < 300; ++batch) {
    fill(events, t_us);
    if (batch % 10 == 0) events[5].x = 5000;  // refused, and repaired around
    push(*pipeline, events);
    if (batch < 100) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // it falls asleep
  }
  pipeline->stop();
  pipeline->join();
  const asap::Ledger ledger = pipeline->ledger();
  return ledger.balanced() && ledger.rejected == 30 && ledger.delivered > 0;
}

bool packages(asap::Scheme& scheme, asap::Execution execution) {
  asap::EventBuffer buffer(16'384);
  asap::Telemetry telemetry(10'000'000, 0);
  Packager packager(buffer, scheme, telemetry, {.execution = execution});
  std::vector<Event> events(kBatch);
  std::int64_t t_us = 0;
  std::int64_t now_ns = 0;
  std::size_t delivered = 0;
  packager.begin(asap::TimeAxis(0, 1.0), 0);
  for (int batch = 0; batch < 300; ++batch) {
    fill(events, t_us);
    buffer.push(events);
    now_ns = std::max(now_ns, 1000 * t_us);
    delivered += consume(packager, now_ns);
  }
  if (delivered == 0) std::printf("%s: nothing delivered\n", scheme.name().data());
  return delivered > 0;
}

bool schemes() {
  asap::Asap2020 asap2020({.rate_bound = 5e5});
  asap::Asap2022 asap2022;
  asap::DeadBeat dead_beat;
  asap::Deadline deadline;
  asap::FixedSize fixed_size({.size = 777});
  asap::FixedTime fixed_time;
  asap::SingleEvent single_event;
  asap::Greedy greedy;
  const std::array<asap::Scheme*, 8> all{&asap2020,   &asap2022,   &dead_beat,    &deadline,
                                         &fixed_size, &fixed_time, &single_event, &greedy};
  bool ok = true;
  for (asap::Scheme* const scheme : all) {
    ok &= packages(*scheme, asap::Execution::whole);
    ok &= packages(*scheme, asap::Execution::anytime);
  }
  return ok;
}

}  // namespace

int main(int count, char** words) {
  if (count > 1) plant(words[1]);
  const bool ok = pipeline() && schemes();
  std::printf("%s\n", ok ? "clean" : "WRONG");
  return ok ? 0 : 1;
}
