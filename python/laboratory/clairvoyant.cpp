// What a scheduler that knows every arrival can do.
#include "study/clairvoyant.hpp"

#include "arrays.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "parts.hpp"

namespace asap::python {

void bind_clairvoyant(py::module_& m) {
  m.def(
      "clairvoyant_latency_us",
      [](const py::array& events, const Held<LinearCost>& cost, double bin_us) {
        const EventSpan span = as_span(events);
        const WithoutGil release;  // pure C++: other Python threads may run
        return static_cast<double>(clairvoyant_latency_ns(span, *cost, bin_us)) * 1e-3;
      },
      py::arg("events").noconvert(), py::arg("cost"), py::arg("bin_us") = 10.0,
      R"(The smallest possible maximum latency without drops.

Parameters
----------
events : ndarray of EVENT_DTYPE, shape (n,)
    A window, in order of time; the algorithm is idle before it and drains the queue after it.
cost : LinearCost
    Without noise.
bin_us : float
    Packages begin and end between bins of this width, us; 1: between any two stamps, 0: anywhere.

Returns
-------
float
    us; 0 for no events.

Raises
------
ValueError
    The cost has noise, or bin_us is out of range.

References
----------
notebooks/theory.md, section 9.
)");
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

}  // namespace asap::python
