#include "live_pipeline.hpp"

#include <pybind11/gil_safe_call_once.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "consumer.hpp"
#include "core/check.hpp"
#include "gil.hpp"

namespace asap::python {
namespace {

// All pipelines; looked at when the interpreter exits. With the GIL.
struct KnownPipeline {
  std::weak_ptr<Pipeline> pipeline;
  std::uint64_t forks;
};
std::vector<KnownPipeline>& known_pipelines() {
  static auto& all = *new std::vector<KnownPipeline>;  // outlives every pipeline
  return all;
}

void make_known(const std::shared_ptr<Pipeline>& pipeline, std::uint64_t forks) {
  std::erase_if(known_pipelines(), [](const KnownPipeline& one) { return one.pipeline.expired(); });
  known_pipelines().push_back({pipeline, forks});
}

void stop_all() {
  std::vector<std::shared_ptr<Pipeline>> running;
  with_gil([&] {
    for (const KnownPipeline& one : known_pipelines()) {
      if (one.forks != forks()) continue;
      if (auto pipeline = one.pipeline.lock()) running.push_back(std::move(pipeline));
    }
  });
  for (const auto& pipeline : running) pipeline->stop(false);
}

struct Worker {
  unsigned long thread = PyThread_get_thread_ident();
  std::uint64_t forks = python::forks();

  bool operator==(const Worker&) const = default;
};

// The workers of this process and of those that it was forked from. With the GIL.
std::vector<Worker>& workers() {
  static auto& all = *new std::vector<Worker>;  // outlives every thread
  return all;
}

// While it lives this thread works for a pipeline. With the GIL.
class AtWork {
 public:
  AtWork() { workers().push_back(self_); }
  ~AtWork() { workers().erase(std::ranges::find(workers(), self_)); }
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;

 private:
  const Worker self_;
};

bool is_at_work(const py::handle& thread) {
  const py::object ident = thread.attr("ident");
  return !ident.is_none() && std::ranges::count(workers(), Worker{ident.cast<unsigned long>()}) > 0;
}

// Whether the program waits for its end for this thread, and for nobody but consumers such as this
// one, whom no one will ever stop. (The hook of atexit comes after that wait.)
bool only_consumers_are_left() {
  PYBIND11_CONSTINIT static py::gil_safe_call_once_and_store<py::module_> storage;
  const py::module_& threading =
      storage.call_once_and_store_result([] { return py::module_::import("threading"); })
          .get_stored();
  const py::object waits = py::getattr(threading, "_SHUTTING_DOWN", py::none());
  if (waits.is(py::bool_(false))) return false;  // cheap: asked for every package
  const py::object main = threading.attr("main_thread")();
  if (waits.is_none() && main.attr("is_alive")().cast<bool>()) return false;
  const auto keeps_alive = [&](const py::handle& thread) {
    return !thread.is(main) && !thread.attr("daemon").cast<bool>();
  };
  for (const py::handle thread : threading.attr("enumerate")()) {
    if (keeps_alive(thread) && !is_at_work(thread)) return false;
  }
  return keeps_alive(threading.attr("current_thread")());
}

Pipeline::Arrival arrival_of(std::optional<double> arrival_time) {
  if (!arrival_time) return std::nullopt;
  require(std::abs(*arrival_time) <= 1e9, "arrival_time", *arrival_time,
          "give time.monotonic() of the arrival, in seconds");
  const std::chrono::nanoseconds since(std::llround(*arrival_time * 1e9));
  return std::chrono::steady_clock::time_point(since);
}

}  // namespace

class LivePipeline::Guest {
 public:
  explicit Guest(const LivePipeline& host) : host_(host) { ++host_.guests_; }
  ~Guest() { --host_.guests_; }
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

 private:
  const LivePipeline& host_;
};

LivePipeline::LivePipeline(Scheme& scheme, const RunConfig& config)
    : pipeline_(std::make_shared<Pipeline>(scheme, config)),
      forks_(forks()),
      push_may_wait_(config.when_full == WhenFull::block) {
  make_known(pipeline_, forks_);
}

LivePipeline::~LivePipeline() {
  if (forks_ != forks()) static_cast<void>(new std::shared_ptr<Pipeline>(std::move(pipeline_)));
}

Pipeline& LivePipeline::native() const {
  require_own_process();
  return *pipeline_;
}

template <class Work>
auto LivePipeline::unheld(Work work) const {
  Pipeline& pipeline = native();
  const WithoutGil released;
  return work(pipeline);
}

void LivePipeline::require_own_process() const {
  if (forks_ == forks()) return;
  throw std::runtime_error(
      "pipeline: created before fork, in the parent process; make a new one in this process, or "
      "use multiprocessing with 'spawn'");
}

void LivePipeline::look_up() const {
  require_own_process();
  check_signals();
}

void LivePipeline::stop_if_deserted() {
  if (!only_consumers_are_left()) return;
  deserted_ = true;
  stop(true);
}

bool LivePipeline::push(const py::array& events, std::optional<double> arrival_time) {
  Pipeline& pipeline = native();
  const EventSpan span = as_span(events);
  const Pipeline::Arrival arrival = arrival_of(arrival_time);
  if (is_exiting() || deserted_) {
    came_at_exit_ += span.size();
    return true;
  }
  // To take the GIL again may take another thread's 5 ms: longer than the push.
  if (!push_may_wait_) return pipeline.push(span, arrival);
  const WithoutGil released;
  return pipeline.push(span, arrival, [&] { with_gil([&] { look_up(); }); });
}

std::optional<LivePackage> LivePipeline::next() {
  Pipeline& pipeline = native();
  if (is_exiting()) return std::nullopt;
  Package package;
  Pipeline::Next next{};
  {
    const Guest guest(*this);
    const AtWork at_work;
    stop_if_deserted();
    const WithoutGil released;
    next = pipeline.next(package, std::chrono::nanoseconds::max(), [&] {
      with_gil([&] {
        look_up();
        stop_if_deserted();
      });
    });
  }
  if (next == Pipeline::Next::ended) return std::nullopt;
  glimpse_.note(package.events);
  LivePackage result{arrays_.array_of(package.events), package};
  result.package.events = {};
  return result;
}

void LivePipeline::run(const py::object& algorithm, const py::object& poll) {
  Pipeline& pipeline = native();
  const Consumer consumer = [this, works = consumer_of(algorithm, arrays_)](const Package& part) {
    works(part);
    glimpse_.note(part.events);
  };
  if (is_exiting()) return;
  const Guest guest(*this);
  const AtWork at_work;
  const WithoutGil released;  // a Python algorithm takes it back per package
  pipeline.run(consumer, [&] {
    with_gil([&] {
      look_up();
      stop_if_deserted();
      if (!poll.is_none()) poll();
    });
  });
}

void LivePipeline::flush() {
  unheld([](Pipeline& pipeline) { pipeline.flush(); });
}

void LivePipeline::stop(bool drain) {
  Pipeline& pipeline = native();
  if (is_exiting()) return;   // has been, or is being
  const WithoutGil released;  // a push under way may need it
  pipeline.stop(drain);
}

void LivePipeline::abandon() {
  if (forks_ != forks() || is_exiting()) return;
  const WithoutGil released;
  pipeline_->abandon();
}

void LivePipeline::start() {
  Pipeline& pipeline = native();
  if (is_exiting()) throw std::runtime_error("pipeline: the interpreter exits");
  deserted_ = false;
  came_at_exit_ = 0;
  const Guest guest(*this);
  const WithoutGil released;
  pipeline.start();
}

void LivePipeline::set_latency(std::chrono::nanoseconds latency) {
  unheld([=](Pipeline& pipeline) { pipeline.set_latency(latency); });
}

void LivePipeline::upstream_lost(std::uint64_t marks, std::uint64_t packets) {
  native().upstream_lost(marks, packets);
}

Ledger LivePipeline::ledger() const {
  return booked(unheld([](const Pipeline& pipeline) { return pipeline.ledger(); }));
}

PipelineStats LivePipeline::stats() const {
  PipelineStats stats = unheld([](const Pipeline& pipeline) { return pipeline.stats(); });
  stats.ledger = booked(stats.ledger);
  return stats;
}

Ledger LivePipeline::booked(Ledger ledger) const noexcept {
  ledger.received += came_at_exit_;
  ledger.pending += came_at_exit_;
  return ledger;
}

py::array LivePipeline::packages() const {
  const Pipeline& pipeline = native();
  if (pipeline.is_open()) {
    throw std::runtime_error(
        "packages: the pipeline is open; stop() it, then read the rows (stats() at any time)");
  }
  if (guests_ > 0) {
    throw std::runtime_error(
        "packages: a consumer still works; wait for the end of its loop, then read the rows");
  }
  return rows_of(pipeline.log());
}

py::array LivePipeline::glimpse(bool more) {
  require_own_process();
  std::vector<Event> events;
  {
    const WithoutGil released;  // a megabyte is written to
    events = glimpse_.take(more);
  }
  return moved_to_array(std::move(events));
}

void stop_pipelines_on_exit() { on_exit(stop_all); }

}  // namespace asap::python
