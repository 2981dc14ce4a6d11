// The rivals: baselines of the benchmark, schemes that only the simulator can run. One row each, as
// in schemes.cpp.
#include <pybind11/pybind11.h>

#include "held.hpp"
#include "parts.hpp"
#include "study/rivals.hpp"

namespace asap::python {
namespace {

namespace py = pybind11;

template <class S>
void bind_rival(py::module_& m, const char* name, const char* doc) {
  Class<S, Scheme>(m, name, doc)
      .def(py::init([](const py::object& latency_ms) {
             return S(time_of_ms("latency_ms", latency_ms));
           }),
           py::arg("latency_ms"));
}

}  // namespace

void bind_rivals(py::module_& m) {
  Class<JaerTimer, Scheme>(
      m, "JaerTimer",
      "Greedy with a timer of half the bound; what is left when it has run is discarded. `cost` is "
      "the simulated algorithm of the same run.")
      .def(py::init([](const py::object& latency_ms, const Held<LinearCost>& cost) {
             return JaerTimer(time_of_ms("latency_ms", latency_ms), *cost);
           }),
           py::arg("latency_ms"), py::arg("cost"));
  bind_rival<GreedyClear>(m, "GreedyClear",
                          "Greedy that discards all but the newest when half the bound is over.");
  bind_rival<SparkPid>(m, "SparkPid", "Batches of half the bound, thinned to the achieved rate.");
}

}  // namespace asap::python
