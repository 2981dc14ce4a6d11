// An application without exceptions and without RTTI, as on-board code often is: it includes every
// header of the hot path, uses their templates, and runs schemes whose type information is nowhere.
#include <cstdio>
#include <string_view>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "asap/filter/gamma_filter.hpp"
#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "asap/runner/replay.hpp"
#include "asap/runner/run_config.hpp"
#include "asap/runner/simulator.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "asap/schemes/scheme.hpp"
#include "asap/telemetry/latency_histogram.hpp"
#include "asap/telemetry/run_log.hpp"
#include "buffer/age_slots.hpp"
#include "buffer/arrival_times.hpp"
#include "buffer/event_buffer.hpp"
#include "core/check.hpp"
#include "core/random.hpp"
#include "oracle/oracle.hpp"
#include "packager/anytime_plan.hpp"
#include "packager/packager.hpp"
#include "packager/rate_meter.hpp"
#include "runner/clock.hpp"
#include "runner/consumer_loop.hpp"
#include "runner/doorbell.hpp"
#include "runner/push_door.hpp"
#include "runner/read_ahead.hpp"
#include "schemes/bounded_scheme.hpp"
#include "schemes/calibration.hpp"
#include "study/realtime.hpp"
#include "telemetry/slot_log.hpp"
#include "telemetry/telemetry.hpp"

#if defined(__cpp_exceptions) || defined(__cpp_rtti)
#error "this file is to be compiled with -fno-exceptions -fno-rtti"
#endif

template class asap::BasicEventBuffer<>;
template class asap::BasicArrivalTimes<>;
template class asap::BasicDoorbell<>;
template class asap::BasicPushDoor<>;
template void asap::require<int>(bool, std::string_view, int, std::string_view);
template void asap::require<double>(bool, std::string_view, double, std::string_view);

namespace {

using asap::Backlog, asap::Decision;

class Own final : public asap::Scheme {
 public:
  Decision decide(const Backlog& backlog) noexcept override {
    return Decision::take(backlog.count);
  }
  std::string_view name() const noexcept override { return "own"; }
};

std::size_t pushed_through_templates(asap::EventSpan events) {
  asap::Validator validator;
  asap::EventBuffer buffer(events.size());
  asap::Doorbell doorbell;
  std::size_t pushed = 0;
  validator.check(events, [&](asap::EventSpan good) { pushed += buffer.push(good); });
  doorbell.announce(buffer.tail());
  doorbell.wait(0, asap::Doorbell::Clock::time_point::min(), [] { return true; });
  return pushed;
}

std::size_t simulated(asap::Scheme& scheme, asap::EventSpan events) {
  asap::Simulator simulator(scheme, asap::LinearCost({.alpha_us = 100, .beta_ns = 50}));
  simulator.feed(events);
  simulator.finish();
  return simulator.ledger().delivered;
}

bool all_of(std::size_t expected, std::size_t actual, const char* by) {
  if (actual != expected) std::printf("%s: %zu of %zu events\n", by, actual, expected);
  return actual == expected;
}

}  // namespace

int main() {
  std::vector<asap::Event> events;
  for (std::int64_t i = 0; i < 1000; ++i) events.push_back({1, 2, 1, 10 * i});
  Own own;
  asap::SingleEvent single_event;
  bool ok = all_of(events.size(), pushed_through_templates(events), "templates");
  ok &= all_of(events.size(), simulated(own, events), "a scheme of its own");
  ok &= all_of(events.size(), simulated(single_event, events), "single_event");
  return ok ? 0 : 1;
}
