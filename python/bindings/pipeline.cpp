// The layer `runner`, live: the pipeline, its packages and its counters.
#include <pybind11/stl.h>

#include "arguments.hpp"
#include "asap/runner/pipeline.hpp"
#include "held.hpp"
#include "layers.hpp"
#include "live_pipeline.hpp"
#include "telemetry.hpp"
#include "validator.hpp"

namespace asap::python::pipeline {
namespace {

double us(std::int64_t ns) { return static_cast<double>(ns) * 1e-3; }

void bind_stats(py::module_& m) {
  py::class_<PipelineStats>(m, "PipelineStats", "How a pipeline does: a snapshot.")
      .def_readonly("ledger", &PipelineStats::ledger)
      .def_property_readonly("latency", [](const PipelineStats& stats) { return stats.latency; })
      .def_readonly("open", &PipelineStats::open)
      .def_readonly("stalled", &PipelineStats::stalled)
      .def_readonly("gap_us", &PipelineStats::gap_us)
      .def_readonly("max_waiting", &PipelineStats::max_waiting)
      .def_readonly("clock_resets", &PipelineStats::clock_resets)
      .def_readonly("upstream_marks", &PipelineStats::upstream_marks)
      .def_readonly("upstream_packets", &PipelineStats::upstream_packets)
      .def_property_readonly("rejected",
                             [](const PipelineStats& stats) { return dict_of(stats.rejected); })
      .def_property_readonly(
          "elapsed_s",
          [](const PipelineStats& stats) { return static_cast<double>(stats.elapsed_ns) * 1e-9; })
      .def_property_readonly("packages",
                             [](const PipelineStats& stats) { return stats.packages.count; })
      .def_property_readonly("to_gamma",
                             [](const PipelineStats& stats) { return stats.packages.to_gamma; })
      .def_property_readonly("size", [](const PipelineStats& stats) { return stats.packages.size; })
      .def_property_readonly("size_max",
                             [](const PipelineStats& stats) { return stats.packages.size_max; })
      .def_property_readonly("gamma_min",
                             [](const PipelineStats& stats) { return stats.packages.gamma_min; })
      .def_property_readonly("latency_bound_us",
                             [](const PipelineStats& stats) { return us(stats.latency_bound_ns); })
      .def_property_readonly("sensor_delay_us",
                             [](const PipelineStats& stats) { return us(stats.sensor_delay_ns); })
      .def_property_readonly(
          "sensor_delay_max_us",
          [](const PipelineStats& stats) { return us(stats.sensor_delay_max_ns); })
      .def_property_readonly("busy_s", [](const PipelineStats& stats) {
        return static_cast<double>(stats.packages.processing_ns) * 1e-9;
      });
}

}  // namespace

void bind(py::module_& m) {
  py::class_<LivePackage>(m, "LivePackage", R"(A package of a pipeline.

Its events are a read-only array in EVENT_DTYPE, valid as long as it is referenced.
)")
      .def_property_readonly("events", [](const LivePackage& self) { return self.events; })
      .def_property_readonly(
          "gamma", [](const LivePackage& self) { return self.package.gamma; },
          "The share of the events that thinning saw for this package and kept.")
      .def_property_readonly(
          "index", [](const LivePackage& self) { return self.package.index; }, "From 0.")
      .def_property_readonly(
          "t_first",
          [](const LivePackage& self) { return static_cast<const Event*>(self.events.data())->t; },
          "Timestamp of the oldest event, us.")
      .def_property_readonly(
          "t_last",
          [](const LivePackage& self) {
            return static_cast<const Event*>(self.events.data())[self.events.size() - 1].t;
          },
          "Timestamp of the newest event, us.")
      .def_property_readonly(
          "lost_before", [](const LivePackage& self) { return self.package.lost_before(); },
          "Events lost (stale, overflow) since the package before.")
      .def_property_readonly(
          "stale_before", [](const LivePackage& self) { return self.package.stale_before; },
          "Events lost as too old since the package before.")
      .def_property_readonly(
          "overflow_before", [](const LivePackage& self) { return self.package.overflow_before; },
          "Events lost to a full ring since the package before.")
      .def_property_readonly(
          "filtered", [](const LivePackage& self) { return self.package.filtered; },
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
      .def("complete", &LivePipeline::complete, "The package in work is finished.")
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
      .def_property_readonly("ledger", &LivePipeline::ledger)
      .def_property_readonly("packages", &LivePipeline::packages)
      .def("rows", &LivePipeline::rows, py::arg("since"),
           "Rows of the log from this number on; for the consumer, between two packages.")
      .def("glimpse", &LivePipeline::glimpse, py::arg("more"),
           "Events, at most 65536, that came to the algorithm since glimpse(more=True).")
      .def_property_readonly("pinned", &LivePipeline::pinned)
      .def("stats", &LivePipeline::stats);

  stop_pipelines_on_exit();
}

}  // namespace asap::python::pipeline
