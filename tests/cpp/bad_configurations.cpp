// The door without exceptions: an application that knows neither exceptions nor RTTI gives a bad
// value to every field of every configuration. Each must be refused by a message that names the
// field. Prints the messages, then how many fields were refused, and ends with 1, as a program does
// whose configuration is refused; with 2 if a message is missing or names another field.
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "asap/runner/pipeline.hpp"
#include "asap/runner/simulator.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"

#if defined(__cpp_exceptions) || defined(__cpp_rtti)
#error "this file is to be compiled with -fno-exceptions -fno-rtti"
#endif

namespace {

using namespace std::chrono_literals;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kTooMany = std::numeric_limits<std::size_t>::max() / 64;

int fields = 0;
int wrong = 0;

template <class Value>
void expect_refusal_of(const std::string& field, const asap::Result<Value>& result) {
  ++fields;
  std::printf("%s\n", result ? "(accepted)" : result.message().c_str());
  if (!result && result.message().starts_with(field + " = ")) return;
  ++wrong;
  std::printf("WRONG: expected a message about %s\n", field.c_str());
}

// ---- schemes: the fields of kParameters, which are all there are

void spoil(double& value) { value = kNaN; }
void spoil(std::chrono::nanoseconds& value) { value = -1ns; }
void spoil(std::size_t& value) { value = 0; }
void spoil(asap::Prefer& value) { value = static_cast<asap::Prefer>(3); }
void spoil(std::optional<double>& value) { value = kNaN; }

template <class Scheme>
void scheme() {
  const auto refuse = [](const auto& named) {
    typename Scheme::Config config;
    spoil(config.*named.field);
    std::string name = named.name;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(config.*named.field)>,
                                 std::chrono::nanoseconds>) {
      name.resize(name.size() - 3);  // "_ms", which the table's names carry
    }
    expect_refusal_of(name, asap::make_scheme<Scheme>(config));
  };
  std::apply([&](const auto&... named) { (refuse(named), ...); }, Scheme::Config::kParameters);
}

// ---- runs. A structured binding of all fields: a new one does not compile until it is tried here

void run_field(const char* field, asap::RunConfig config) {
  asap::Greedy scheme;
  expect_refusal_of(field, asap::make_pipeline(scheme, config));
  expect_refusal_of(field, asap::make_pipeline(config, [](const asap::Package&) {}));
}

// Every value of these is valid: flush, seed, before, max_copied, prefault, on_worker_start.
void runs() {
  const auto& [latency, capacity, seed, validator, execution, flush, before, when_full, keep_mask,
               log_rows, max_copied, prefault, on_worker_start] = asap::RunConfig{};
  const auto& [width, height, on_bad, reorder_tolerance, warmup_discard] = validator;
  static_cast<void>(std::tie(latency, capacity, seed, execution, flush, before, when_full,
                             keep_mask, log_rows, max_copied, prefault, on_worker_start));
  static_cast<void>(std::tie(width, height, on_bad, reorder_tolerance, warmup_discard));
  run_field("latency", {.latency = -5us});
  run_field("capacity", {.capacity = kTooMany});
  run_field("capacity", {.capacity = std::size_t{1} << 40});  // no memory
  run_field("width", {.validator = {.width = -1}});
  run_field("height", {.validator = {.height = 65'537}});
  run_field("on_bad", {.validator = {.on_bad = static_cast<asap::OnBad>(9)}});
  run_field("reorder_tolerance", {.validator = {.reorder_tolerance = -1us}});
  run_field("warmup_discard", {.validator = {.warmup_discard = -1us}});
  run_field("execution", {.execution = static_cast<asap::Execution>(-1)});
  run_field("when_full", {.when_full = static_cast<asap::WhenFull>(4)});
  run_field("keep_mask", {.keep_mask = true});
  run_field("log_rows", {.log_rows = kTooMany});

  asap::Deadline deadline{{.latency = 5ms}};
  expect_refusal_of("latency", asap::make_pipeline(deadline, {.latency = 10ms}));
  expect_refusal_of("algorithm", asap::make_pipeline({}, asap::Consumer{}));
}

void cost_field(const char* field, const asap::LinearCostConfig& cost) {
  asap::Greedy scheme;
  expect_refusal_of(field, asap::make_simulator(scheme, cost));
}

void costs() {
  const auto& [alpha_us, beta_ns, noise, seed, drift, outages] = asap::LinearCostConfig{};
  static_cast<void>(std::tie(alpha_us, beta_ns, noise, seed, drift, outages));
  cost_field("alpha_us", {.alpha_us = -1});
  cost_field("beta_ns", {.beta_ns = kNaN});
  cost_field("noise", {.noise = 6});
  cost_field("drift", {.drift = {1, -1}});
  cost_field("outages", {.outages = {{.begin_ns = 2, .end_ns = 1}}});
  asap::Greedy scheme;
  expect_refusal_of("latency", asap::make_simulator(scheme, {}, {.latency = 0s}));
}

// ---- trackers

void tracker_field(const char* field, const asap::ClusterTrackerConfig& config) {
  expect_refusal_of(field, asap::make_tracker(config));
}

void trackers() {
  const auto& [width, height, slots, support, support_window, birth_radius_px, max_radius_px,
               confirm_events, coast] = asap::ClusterTrackerConfig{};
  static_cast<void>(std::tie(width, height, slots, support, support_window, birth_radius_px,
                             max_radius_px, confirm_events, coast));
  tracker_field("width", {.width = 0, .height = 260});
  tracker_field("height", {.width = 346, .height = 0});
  tracker_field("slots", {.width = 346, .height = 260, .slots = 257});
  tracker_field("support",
                {.width = 346, .height = 260, .support = static_cast<asap::ClusterSupport>(3)});
  tracker_field("support_window", {.width = 346, .height = 260, .support_window = 0s});
  tracker_field("birth_radius_px", {.width = 346, .height = 260, .birth_radius_px = kNaN});
  tracker_field("max_radius_px", {.width = 346, .height = 260, .max_radius_px = 5'000});
  tracker_field("confirm_events", {.width = 346, .height = 260, .confirm_events = 1});
  tracker_field("coast", {.width = 346, .height = 260, .coast = 61s});
}

void published_field(const char* field, const asap::PublishedClusterTrackerConfig& config) {
  expect_refusal_of(field, asap::make_tracker<asap::PublishedClusterTracker>(config));
}

void published_trackers() {
  const auto& [width, height, window, radius, probes, weight, min_size, seed] =
      asap::PublishedClusterTrackerConfig{};
  static_cast<void>(std::tie(width, height, window, radius, probes, weight, min_size, seed));
  published_field("width", {.width = 0, .height = 260});
  published_field("height", {.width = 346, .height = -1});
  published_field("window", {.width = 346, .height = 260, .window = 0});
  published_field("radius", {.width = 346, .height = 260, .radius = kNaN});
  published_field("probes", {.width = 346, .height = 260, .probes = -1});
  published_field("weight", {.width = 346, .height = 260, .weight = 2});
  published_field("min_size", {.width = 346, .height = 260, .min_size = -1});
}

// The good ones are made, and work.
bool good() {
  auto tracker = asap::make_tracker({.width = 346, .height = 260});
  auto scheme = asap::make_scheme({.latency = 10ms});
  auto single = asap::make_scheme<asap::SingleEvent>();
  if (!tracker || !scheme || !single) return false;
  auto simulator = asap::make_simulator(*scheme, {.alpha_us = 100, .beta_ns = 50});
  auto pipeline = asap::make_pipeline({.latency = 1000s},
                                      [&](asap::EventSpan events) { tracker->process(events); });
  if (!simulator || !pipeline) return false;
  const std::array<asap::Event, 2> events{{{1, 2, 1, 10}, {3, 4, 0, 20}}};
  simulator->feed(events);
  simulator->finish();
  pipeline->push(events);
  pipeline->stop();
  pipeline->join();
  return simulator->ledger().delivered == 2 && pipeline->ledger().delivered == 2;
}

}  // namespace

int main() {
  scheme<asap::Asap2020>();
  scheme<asap::Asap2022>();
  scheme<asap::DeadBeat>();
  scheme<asap::Deadline>();
  scheme<asap::FixedSize>();
  scheme<asap::FixedTime>();
  scheme<asap::Greedy>();
  runs();
  costs();
  trackers();
  published_trackers();
  const bool made = good();
  if (!made) std::printf("WRONG: a good configuration was refused\n");
  std::printf("%d of %d fields refused by name\n", fields - wrong, fields);
  return wrong == 0 && made ? 1 : 2;
}
