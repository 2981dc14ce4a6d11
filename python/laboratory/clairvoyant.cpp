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
      [](const py::array& events, const Held<LinearCost>& cost) {
        const EventSpan span = as_span(events);
        const auto latency_ns = without_gil([&] { return clairvoyant_latency_ns(span, *cost); });
        return static_cast<double>(latency_ns) * 1e-3;
      },
      py::arg("events").noconvert(), py::arg("cost"),
      "The smallest possible maximum latency without drops, us: notebooks/theory.md, section 9.");
  m.def(
      "exact_clairvoyant",
      [](const py::array& events, const Held<LinearCost>& cost, double latency_us) {
        const EventSpan span = as_span(events);
        return without_gil([&] { return exact_clairvoyant(span, *cost, latency_us); });
      },
      py::arg("events").noconvert(), py::arg("cost"), py::arg("latency_us"),
      "See asap_laboratory.exact_oracle.");
}

}  // namespace asap::python
