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

  stop_pipelines_on_exit();
}

}  // namespace asap::python::pipeline
