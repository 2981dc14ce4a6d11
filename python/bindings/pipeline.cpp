// The layer `runner`, live: the pipeline as Python holds it, its packages and its counters.
//
// It waits without the GIL and looks at Ctrl-C every 20 ms; ends when the interpreter exits;
// refuses a process that was forked from that of its making, where other threads may have been
// inside.
#include "asap/runner/pipeline.hpp"

#include <pybind11/gil_safe_call_once.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "callbacks.hpp"
#include "core/check.hpp"
#include "gil.hpp"
#include "glimpse.hpp"
#include "held.hpp"
#include "package_arrays.hpp"
#include "telemetry.hpp"

namespace asap::python::pipeline {
namespace {

// ---- the end of the program ----

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

// Whether the program, at its end, waits for this thread and otherwise for consumers like it alone:
// nothing will ever stop them. (The hook of atexit comes after that wait.)
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

// ---- the pipeline ----

struct LivePackage {
  py::array events;
  Package package;  // but for its events, which were the ring's
};

class LivePipeline {
 public:
  LivePipeline(Scheme& scheme, const RunConfig& config)
      : pipeline_(std::make_shared<Pipeline>(scheme, config)),
        push_may_wait_(config.when_full == WhenFull::block) {
    make_known(pipeline_, forks_);
  }
  // In a forked process nothing is destroyed: a lock inside may be held by a thread that is gone.
  ~LivePipeline() {
    if (forks_ != forks()) static_cast<void>(new std::shared_ptr<Pipeline>(std::move(pipeline_)));
  }
  LivePipeline(const LivePipeline&) = delete;
  LivePipeline& operator=(const LivePipeline&) = delete;

  // False: refused, nothing is counted. Waits only where the ring's rule is to block. While the
  // program ends events are taken and stay pending, without a word.
  bool push(const py::array& events, std::optional<double> arrival_time) {
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

  // None: stopped.
  std::optional<LivePackage> next() {
    Pipeline& pipeline = native();
    if (is_exiting()) return std::nullopt;
    Package package;
    const auto wait = [&] {
      const Guest guest(*this);
      const AtWork at_work;
      stop_if_deserted();
      const WithoutGil released;
      return pipeline.next(package, std::chrono::nanoseconds::max(), [&] {
        with_gil([&] {
          look_up();
          stop_if_deserted();
        });
      });
    };
    if (wait() == Pipeline::Next::ended) return std::nullopt;
    glimpse_.note(package.events);
    LivePackage result{arrays_.array_of(package.events), package};
    result.package.events = {};
    return result;
  }

  // Until it is stopped; `poll` is called about every 20 ms.
  void run(const py::object& algorithm, const py::object& poll) {
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

  void flush() {
    without_gil([&] { native().flush(); });
  }

  void stop(bool drain) {
    Pipeline& pipeline = native();
    if (is_exiting()) return;                    // has been, or is being
    without_gil([&] { pipeline.stop(drain); });  // a push under way may need it
  }

  // Nothing in a forked process, so that a with block can be left there.
  void abandon() {
    if (forks_ != forks() || is_exiting()) return;
    without_gil([&] { pipeline_->abandon(); });
  }

  void start() {
    Pipeline& pipeline = native();
    if (is_exiting()) throw std::runtime_error("pipeline: the interpreter exits");
    deserted_ = false;
    came_at_exit_ = 0;
    const Guest guest(*this);
    without_gil([&] { pipeline.start(); });
  }

  void set_latency(std::chrono::nanoseconds latency) {
    without_gil([&] { native().set_latency(latency); });
  }

  void upstream_lost(std::uint64_t marks, std::uint64_t packets) {
    native().upstream_lost(marks, packets);
  }

  bool is_open() const { return native().is_open(); }

  Ledger ledger() const {
    return booked(without_gil([&] { return native().ledger(); }));
  }

  PipelineStats stats() const {
    PipelineStats stats = without_gil([&] { return native().stats(); });
    stats.ledger = booked(stats.ledger);
    return stats;
  }

  // The newest rows of the log: a copy. RuntimeError before the end of the run.
  py::array packages() const {
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

  // Those that the log keeps of the rows from number `since` on. The consumer's thread, between
  // two packages.
  py::array rows(std::size_t since) const { return rows_of(native().log(), since); }

  // Some of the events that came to the algorithm since the call before, if that one wanted more.
  py::array glimpse(bool more) {
    require_own_process();
    return moved_to_array(without_gil([&] { return glimpse_.take(more); }));  // writes a megabyte
  }

  // Arrays of packages that Python still holds.
  std::size_t pinned() const noexcept { return arrays_.pinned(); }

 private:
  // A thread that may change the log.
  class Guest {
   public:
    explicit Guest(const LivePipeline& host) : host_(host) { ++host_.guests_; }
    ~Guest() { --host_.guests_; }
    Guest(const Guest&) = delete;
    Guest& operator=(const Guest&) = delete;

   private:
    const LivePipeline& host_;
  };

  Pipeline& native() const {
    require_own_process();
    return *pipeline_;
  }

  void require_own_process() const {
    if (forks_ == forks()) return;
    throw std::runtime_error(
        "pipeline: created before fork, in the parent process; make a new one in this process, or "
        "use multiprocessing with 'spawn'");
  }

  // What a thread that waits must not miss: Ctrl-C, a fork.
  void look_up() const {
    require_own_process();
    check_signals();
  }

  // At the end of the program.
  void stop_if_deserted() {
    if (!only_consumers_are_left()) return;
    deserted_ = true;
    stop(true);
  }

  // With the events that came at the end.
  Ledger booked(Ledger ledger) const noexcept {
    ledger.received += came_at_exit_;
    ledger.pending += came_at_exit_;
    return ledger;
  }

  std::shared_ptr<Pipeline> pipeline_;
  const std::uint64_t forks_ = forks();
  const bool push_may_wait_;
  std::uint64_t came_at_exit_ = 0;  // events
  bool deserted_ = false;           // no thread is left that would stop it
  PackageArrays arrays_;
  Glimpse glimpse_;
  mutable int guests_ = 0;
};

// ---- the classes of Python ----

double us(std::int64_t ns) { return static_cast<double>(ns) * 1e-3; }
double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

void bind_stats(py::module_& m) {
  py::class_<PipelineStats> type(m, "PipelineStats", "How a pipeline does: a snapshot.");
  const auto property = [&](const char* name, auto read) {
    type.def_property_readonly(name, [=](const PipelineStats& stats) { return read(stats); });
  };
  property("ledger", [](const auto& stats) { return dict_of(stats.ledger); });
  property("rejected", [](const auto& stats) { return dict_of(stats.rejected); });
  property("latency", [](const auto& stats) { return stats.latency; });
  property("open", [](const auto& stats) { return stats.open; });
  property("stalled", [](const auto& stats) { return stats.stalled; });
  property("gap_us", [](const auto& stats) { return stats.gap_us; });
  property("max_waiting", [](const auto& stats) { return stats.max_waiting; });
  property("clock_resets", [](const auto& stats) { return stats.clock_resets; });
  property("upstream_marks", [](const auto& stats) { return stats.upstream_marks; });
  property("upstream_packets", [](const auto& stats) { return stats.upstream_packets; });
  property("elapsed_s", [](const auto& stats) { return seconds(stats.elapsed_ns); });
  property("busy_s", [](const auto& stats) { return seconds(stats.packages.processing_ns); });
  property("packages", [](const auto& stats) { return stats.packages.count; });
  property("to_gamma", [](const auto& stats) { return stats.packages.to_gamma; });
  property("size", [](const auto& stats) { return stats.packages.size; });
  property("size_max", [](const auto& stats) { return stats.packages.size_max; });
  property("gamma_min", [](const auto& stats) { return stats.packages.gamma_min; });
  property("latency_bound_us", [](const auto& stats) { return us(stats.latency_bound_ns); });
  property("sensor_delay_us", [](const auto& stats) { return us(stats.sensor_delay_ns); });
  property("sensor_delay_max_us", [](const auto& stats) { return us(stats.sensor_delay_max_ns); });
}

}  // namespace

void bind(py::module_& m) {
  const auto part = [](auto Package::* field) {
    return [=](const LivePackage& self) { return self.package.*field; };
  };
  const auto at = [](const LivePackage& self, py::ssize_t place) {
    return static_cast<const Event*>(self.events.data())[place].t;
  };
  py::class_<LivePackage>(m, "LivePackage", R"(A package of a pipeline.

Its events are a read-only array in EVENT_DTYPE, valid as long as it is referenced.
)")
      .def_property_readonly("events", [](const LivePackage& self) { return self.events; })
      .def_property_readonly("gamma", part(&Package::gamma),
                             "The share of the events that thinning saw for this package and kept.")
      .def_property_readonly("index", part(&Package::index), "From 0.")
      .def_property_readonly(
          "t_first", [=](const LivePackage& self) { return at(self, 0); },
          "Timestamp of the oldest event, us.")
      .def_property_readonly(
          "t_last", [=](const LivePackage& self) { return at(self, self.events.size() - 1); },
          "Timestamp of the newest event, us.")
      .def_property_readonly(
          "lost_before", [](const LivePackage& self) { return self.package.lost_before(); },
          "Events lost (stale, overflow) since the package before.")
      .def_property_readonly("stale_before", part(&Package::stale_before),
                             "Events lost as too old since the package before.")
      .def_property_readonly("overflow_before", part(&Package::overflow_before),
                             "Events lost to a full ring since the package before.")
      .def_property_readonly(
          "filtered", part(&Package::filtered),
          "Of the raw events behind this package, those that the filter in front has dropped.")
      .def("__len__", [](const LivePackage& self) { return self.events.size(); });

  bind_stats(m);

  py::class_<LivePipeline>(m, "LivePipeline", "Live events to the algorithm.")
      .def(py::init([](const Held<Scheme>& scheme, const RunConfig& config) {
             return std::make_unique<LivePipeline>(*scheme, config);
           }),
           py::arg("scheme"), py::arg("config"), py::keep_alive<1, 2>())
      .def("push", &LivePipeline::push, py::arg("events").noconvert(),
           py::arg("arrival_time") = py::none(), "False: refused, nothing is counted.")
      .def(
          "upstream_lost",
          [](LivePipeline& self, const py::object& marks, const py::object& packets) {
            self.upstream_lost(whole_number("marks", marks), whole_number("packets", packets));
          },
          py::arg("marks"), py::arg("packets") = 0)
      .def("next", &LivePipeline::next,
           "The next package, with the one before completed; None: stopped.")
      .def("abandon", &LivePipeline::abandon,
           "The package in work is given up and the pipeline stopped.")
      .def("run", &LivePipeline::run, py::arg("algorithm"), py::arg("poll") = py::none(),
           "Works on this thread until the pipeline is stopped; calls poll() every 20 ms.")
      .def("flush", &LivePipeline::flush)
      .def("stop", &LivePipeline::stop, py::arg("drain") = true)
      .def("start", &LivePipeline::start)
      .def(
          "set_latency",
          [](LivePipeline& self, const py::object& latency_ms) {
            self.set_latency(time_of_ms("latency_ms", latency_ms));
          },
          py::arg("latency_ms"))
      .def_property_readonly("is_open", &LivePipeline::is_open)
      .def_property_readonly("ledger",
                             [](const LivePipeline& self) { return dict_of(self.ledger()); })
      .def_property_readonly("packages", &LivePipeline::packages)
      .def("rows", &LivePipeline::rows, py::arg("since"),
           "Rows of the log from this number on; for the consumer, between two packages.")
      .def("glimpse", &LivePipeline::glimpse, py::arg("more"),
           "Events, at most 65536, that came to the algorithm since glimpse(more=True).")
      .def_property_readonly("pinned", &LivePipeline::pinned)
      .def("stats", &LivePipeline::stats);

  on_exit(stop_all);
}

}  // namespace asap::python::pipeline
