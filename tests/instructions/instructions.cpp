// What callgrind counts: a live pipeline in one thread, on a clock of its own, so that every run
// takes the same instructions.
//
//   instructions keep|thin|deadline EVENTS
//   instructions backlog EVENTS PUSH
//   instructions compiler
//
// Pushes of 1000 events, one per us; packages of 1000 events of which all, or half, are kept; or
// those that Deadline makes of the same stream. backlog: Deadline with pushes of PUSH events;
// prints how often it has decided, and observed.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/deadline.hpp"
#include "runner/system.hpp"

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kPackage = 1000;

#if defined(__x86_64__)
constexpr const char* kMachine = "x86_64";
#else
constexpr const char* kMachine = "other";
#endif

asap::System::Clock::time_point now;

class Fixed final : public asap::Scheme {
 public:
  explicit Fixed(double gamma) : keep_(gamma) {}
  asap::Decision decide(const asap::Backlog&) noexcept override {
    return asap::Decision::take(kPackage, keep_);
  }
  std::string_view name() const noexcept override { return "fixed"; }

 private:
  const double keep_;
};

// Deadline, whose calls are counted.
class Counted final : public asap::Scheme {
 public:
  asap::Decision decide(const asap::Backlog& backlog) noexcept override {
    ++decisions;
    return deadline_.decide(backlog);
  }
  void observe(const asap::Outcome& outcome) noexcept override {
    ++observations;
    deadline_.observe(outcome);
  }
  void reset(asap::Execution execution) noexcept override { deadline_.reset(execution); }
  std::string_view name() const noexcept override { return deadline_.name(); }
  std::int64_t latency_bound_ns() const noexcept override { return deadline_.latency_bound_ns(); }
  void set_latency_bound_ns(std::int64_t bound_ns) noexcept override {
    deadline_.set_latency_bound_ns(bound_ns);
  }

  std::size_t decisions = 0;
  std::size_t observations = 0;

 private:
  asap::Deadline deadline_{{.latency = 10ms}};
};

std::size_t run(asap::Scheme& scheme, std::size_t events, std::size_t push = kPackage) {
  asap::Pipeline pipeline(scheme, {.latency = 10ms,
                                   .capacity = 65'536,
                                   .validator = {.width = 346, .height = 260},
                                   .execution = asap::Execution::whole,
                                   .log_rows = 0,
                                   .prefault = true});
  std::vector<asap::Event> batch(push, {.x = 100, .y = 100, .p = 1, .t = 0});
  std::int64_t t = 0;
  std::size_t delivered = 0;
  for (std::size_t pushed = 0; pushed < events; pushed += push) {
    for (asap::Event& event : batch) event.t = t++;
    now += std::chrono::microseconds(push);
    pipeline.push(batch);
    asap::Package package;
    while (pipeline.next(package, std::chrono::nanoseconds(0)) == asap::Pipeline::Next::package) {
      delivered += package.events.size();
      now += std::chrono::microseconds(100) + std::chrono::nanoseconds(300) * package.events.size();
      pipeline.complete();
    }
  }
  return delivered;
}

}  // namespace

asap::System::Clock::time_point asap::System::now() noexcept { return ::now; }
void asap::System::sleep(Word&, Clock::time_point) noexcept {}
void asap::System::wake(Word&) noexcept {}

int main(int count, char** words) {
  const std::string_view what = count > 1 ? words[1] : "";
  if (what == "compiler") {
#if defined(__clang__)
    std::printf("clang-%d-%s\n", __clang_major__, kMachine);
#else
    std::printf("gcc-%d.%d-%s\n", __GNUC__, __GNUC_MINOR__, kMachine);
#endif
    return 0;
  }
  if (count < 3) return 2;
  const auto events = static_cast<std::size_t>(std::atoll(words[2]));
  if (what == "backlog" && count > 3) {
    Counted counted;
    run(counted, events, static_cast<std::size_t>(std::atoll(words[3])));
    std::printf("%zu %zu\n", counted.decisions, counted.observations);
    return 0;
  }
  asap::Deadline deadline{{.latency = 10ms}};
  Fixed fixed(what == "keep" ? 1.0 : 0.5);
  asap::Scheme& scheme = what == "deadline" ? static_cast<asap::Scheme&>(deadline) : fixed;
  return run(scheme, events) > 0 ? 0 : 1;
}
