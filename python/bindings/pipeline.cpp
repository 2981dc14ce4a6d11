// The layer `runner`, live: the pipeline and its packages. Waits without the GIL.
#include <pybind11/stl.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "asap/core/check.hpp"
#include "asap/runner/pipeline.hpp"
#include "consumer.hpp"
#include "layers.hpp"
#include "package_arrays.hpp"
#include "telemetry.hpp"

namespace asap::python {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(50);  // Ctrl-C is seen this soon

struct LivePackage {
  py::array events;
  Package package;
};

class LivePipeline {
 public:
  LivePipeline(Scheme& scheme, const RunConfig& config) : pipeline_(scheme, config) {}

  Pipeline& native() noexcept { return pipeline_; }

  // None: stopped.
  std::optional<LivePackage> next() {
    for (;;) {
      Package package;
      Pipeline::Next next{};
      {
        const py::gil_scoped_release release;
        next = pipeline_.next(package, kPatience);
      }
      if (next == Pipeline::Next::ended) return std::nullopt;
      if (next == Pipeline::Next::package) {
        LivePackage result{arrays_.array_of(package.events), package};
        result.package.events = {};  // the ring's; the array is Python's
        return result;
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
  }

 private:
  Pipeline pipeline_;
  PackageArrays arrays_;
};

Pipeline::Arrival arrival_of(std::optional<double> arrival_time) {
  if (!arrival_time) return std::nullopt;
  require(std::abs(*arrival_time) <= 1e9, "arrival_time", *arrival_time,
          "give time.monotonic() of the arrival, in seconds");
  const std::chrono::nanoseconds since(std::llround(*arrival_time * 1e9));
  return std::chrono::steady_clock::time_point(since);
}

py::dict dict_of(const Rejections& by) {
  py::dict reasons;
  reasons["nonmonotonic"] = by.nonmonotonic;
  reasons["out_of_bounds"] = by.out_of_bounds;
  reasons["bad_polarity"] = by.bad_polarity;
  reasons["bad_record"] = by.bad_record;
  reasons["before_start"] = by.before_start;
  return reasons;
}

void bind_stats(py::module_& m) {
  py::class_<PipelineStats>(m, "PipelineStats", "How a pipeline does: a snapshot.")
      .def_readonly("ledger", &PipelineStats::ledger)
      .def_readonly("latency", &PipelineStats::latency)
      .def_readonly("open", &PipelineStats::open)
      .def_readonly("clock_resets", &PipelineStats::clock_resets)
      .def_readonly("upstream_marks", &PipelineStats::upstream_marks)
      .def_readonly("upstream_packets", &PipelineStats::upstream_packets)
      .def_property_readonly("rejected",
                             [](const PipelineStats& stats) { return dict_of(stats.rejected); })
      .def_property_readonly(
          "elapsed_s",
          [](const PipelineStats& stats) { return static_cast<double>(stats.elapsed_ns) * 1e-9; })
      .def_property_readonly("packages",
                             [](const PipelineStats& stats) { return stats.packages.count.load(); })
      .def_property_readonly(
          "thinned", [](const PipelineStats& stats) { return stats.packages.thinned.load(); })
      .def_property_readonly("size",
                             [](const PipelineStats& stats) { return stats.packages.size.load(); })
      .def_property_readonly(
          "size_max", [](const PipelineStats& stats) { return stats.packages.size_max.load(); })
      .def_property_readonly(
          "gamma_min", [](const PipelineStats& stats) { return stats.packages.gamma_min.load(); })
      .def_property_readonly("busy_s", [](const PipelineStats& stats) {
        return static_cast<double>(stats.packages.processing_ns.load()) * 1e-9;
      });
}

}  // namespace

void bind_pipeline(py::module_& m) {
  py::class_<LivePackage>(m, "LivePackage", R"(A package of a pipeline.

Its events are a read-only array in EVENT_DTYPE, valid as long as it is referenced.
)")
      .def_property_readonly("events", [](const LivePackage& self) { return self.events; })
      .def_property_readonly(
          "gamma", [](const LivePackage& self) { return self.package.gamma; },
          "Kept / raw events of this package.")
      .def_property_readonly(
          "keep", [](const LivePackage& self) { return self.package.keep; },
          "The kept fraction smoothed over about 20 ms, for set_keep.")
      .def_property_readonly(
          "index", [](const LivePackage& self) { return self.package.index; }, "From 0.")
      .def_property_readonly(
          "t_first",
          [](const LivePackage& self) { return static_cast<const Event*>(self.events.data())->t; },
          "Stamp of the oldest event, us.")
      .def_property_readonly(
          "t_last",
          [](const LivePackage& self) {
            return static_cast<const Event*>(self.events.data())[self.events.size() - 1].t;
          },
          "Stamp of the newest event, us.")
      .def_property_readonly(
          "lost_before", [](const LivePackage& self) { return self.package.lost_before(); },
          "Events lost (stale, overflow) since the package before.")
      .def("__len__", [](const LivePackage& self) { return self.events.size(); });

  bind_stats(m);

  py::class_<LivePipeline>(m, "LivePipeline", "Live events to the algorithm.")
      .def(py::init<Scheme&, const RunConfig&>(), py::arg("scheme"), py::arg("config"),
           py::keep_alive<1, 2>())
      .def(
          "push",
          [](LivePipeline& self, const py::array& events, std::optional<double> arrival_time) {
            return self.native().push(as_span(events), arrival_of(arrival_time));
          },
          py::arg("events").noconvert(), py::arg("arrival_time") = py::none(),
          "False: refused, nothing is counted.")
      .def(
          "upstream_lost",
          [](LivePipeline& self, std::uint64_t marks, std::uint64_t packets) {
            self.native().upstream_lost(marks, packets);
          },
          py::arg("marks"), py::arg("packets") = 0)
      .def("next", &LivePipeline::next,
           "The next package, with the one before completed; None: stopped.")
      .def(
          "abandon", [](LivePipeline& self) { self.native().abandon(); },
          py::call_guard<py::gil_scoped_release>(),
          "The package in work is given up and the pipeline stopped.")
      .def(
          "complete", [](LivePipeline& self) { self.native().complete(); },
          "The package in work is finished.")
      .def(
          "run",
          [](LivePipeline& self, const py::object& algorithm) {
            const Consumer consumer = consumer_of(algorithm);
            const py::gil_scoped_release release;  // a Python algorithm takes it back per package
            self.native().run(consumer, [] {
              const py::gil_scoped_acquire acquire;
              if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            });
          },
          py::arg("algorithm"), "Works on this thread until the pipeline is stopped.")
      .def(
          "flush", [](LivePipeline& self) { self.native().flush(); },
          py::call_guard<py::gil_scoped_release>())
      .def(
          "stop", [](LivePipeline& self, bool drain) { self.native().stop(drain); },
          py::arg("drain") = true,
          py::call_guard<py::gil_scoped_release>())  // a push under way may need it
      .def("start", [](LivePipeline& self) { self.native().start(); })
      .def_property_readonly("is_open", [](LivePipeline& self) { return self.native().is_open(); })
      .def_property_readonly("ledger", [](LivePipeline& self) { return self.native().ledger(); })
      .def("stats", [](LivePipeline& self) { return self.native().stats(); });
}

}  // namespace asap::python
