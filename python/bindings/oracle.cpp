// The layer `oracle`.
#include "oracle/oracle.hpp"
#include "arguments.hpp"
#include "arrays.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "layers.hpp"
#include "oracle/clairvoyant.hpp"

namespace asap::python::oracle {

void bind(py::module_& m) {
  py::class_<Oracle>(
      m, "Oracle",
      R"(OB(L): no policy finishes more events in time, unless it knows the random part of the cost.

Fed chunk by chunk; notebooks/theory.md, section 9.

Parameters
----------
cost : LinearCost
    What the algorithm costs.
latency_us : float
    The latency bound, us.
execution : {"anytime", "whole"}
    "whole": the algorithm takes a package in one call: with noise, cheap packages can't run on.
)")
      .def(py::init(
               [](const Held<LinearCost>& cost, double latency_us, const std::string& execution) {
                 return Oracle(*cost, latency_us, execution_from(execution));
               }),
           py::arg("cost"), py::arg("latency_us"), py::arg("execution") = "anytime")
      .def(
          "feed",
          [](Oracle& self, const py::array& events) {
            const EventSpan span = as_span(events);
            const WithoutGil release;  // pure C++: other Python threads may run
            self.feed(span);
          },
          py::arg("events").noconvert(), "Events in arrival order.")
      .def_property_readonly("bound", &Oracle::bound,
                             "Of the events so far: how many can be finished in time.");

  m.def(
      "exact_clairvoyant",
      [](const py::array& events, const Held<LinearCost>& cost, double latency_us,
         double max_steps) {
        const EventSpan span = as_span(events);
        const WithoutGil release;  // pure C++: other Python threads may run
        return exact_clairvoyant(span, *cost, latency_us, max_steps);
      },
      py::arg("events").noconvert(), py::arg("cost"), py::arg("latency_us"),
      py::arg("max_steps") = kMaxExactSteps,
      R"(The largest number of events that any scheduler can finish in time, in whole packages.

Parameters
----------
events : ndarray of EVENT_DTYPE, shape (n,)
    In order of time.
cost : LinearCost
    Its mean counts: without drift and outages.
latency_us : float
    The latency bound, us; an event that ends at the bound is in time.
max_steps : float
    Work that may be spent, in steps of the order of a nanosecond.

Returns
-------
int
    EC(L), events.

Raises
------
ValueError
    The cost drifts or has outages, or the events are too many; then with the number that fits.

References
----------
notebooks/theory.md, section 9.
)");
}

}  // namespace asap::python::oracle
