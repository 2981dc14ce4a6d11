// The layer `oracle`.
#include "oracle/oracle.hpp"

#include "arrays.hpp"
#include "held.hpp"
#include "keywords.hpp"

namespace asap::python::oracle {

void bind(py::module_& m) {
  py::class_<Oracle>(
      m, "Oracle",
      R"(OB(L): no policy finishes more events in time, unless it knows the random part of the cost.

Fed chunk by chunk; notebooks/theory.md, section 9.

Parameters
----------
cost : LinearCost
    The simulated algorithm.
latency_us : float
    The latency bound, us.
execution : {"anytime", "whole"}
    "whole": the algorithm takes a package in one call: with noise, cheap packages can't run on.
)")
      .def(py::init(
               [](const Held<LinearCost>& cost, double latency_us, const py::object& execution) {
                 return Oracle(*cost, latency_us, chosen(kExecutions, "execution", execution));
               }),
           py::arg("cost"), py::arg("latency_us"), py::arg("execution") = "anytime")
      .def("feed", &feed_unheld<Oracle>, py::arg("events").noconvert(), "Events in arrival order.")
      .def_property_readonly("bound", &Oracle::bound,
                             "Of the events so far: how many can be finished in time.");
}

}  // namespace asap::python::oracle
