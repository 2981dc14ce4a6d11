// The layer `schemes`: the schemes that a user chooses from. Keyword-only, all with defaults.
#include <pybind11/stl.h>

#include "arguments.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/fixed_size.hpp"
#include "asap/schemes/fixed_time.hpp"
#include "asap/schemes/greedy.hpp"
#include "asap/schemes/single_event.hpp"
#include "layers.hpp"

namespace asap::python {
namespace {

namespace py = pybind11;

py::dict parameters(const Scheme& scheme) {
  py::dict result;
  for (const auto& [name, value] : scheme.parameters()) result[py::str(name)] = py::cast(value);
  return result;
}

std::string repr(const py::object& scheme) {
  std::string text = py::cast<std::string>(py::type::of(scheme).attr("__name__")) + "(";
  const char* separator = "";
  for (const auto& [name, value] : py::cast<py::dict>(scheme.attr("parameters"))) {
    text.append(separator).append(py::cast<std::string>(name)).append("=");
    text.append(py::cast<std::string>(py::repr(value)));
    separator = ", ";
  }
  return text + ")";
}

}  // namespace

void bind_schemes(py::module_& m) {
  py::class_<Scheme>(m, "Scheme", "The rule that decides size and gamma of the next package.")
      .def_property_readonly("name", &Scheme::name, "Its name on the command line and in files.")
      .def_property_readonly("parameters", &parameters, "The constructor's arguments by name.")
      .def("__repr__", &repr);

  py::class_<FixedSize, Scheme>(m, "FixedSize", R"(Packages of a fixed number of events.

Flushed when the oldest event has waited for the latency bound.

Parameters
----------
size : int
    Events per package, at least 1.
)")
      .def(py::init([](const py::object& size) {
             return FixedSize({.size = whole_number("size", size)});
           }),
           py::kw_only(), py::arg("size") = 1000);

  py::class_<FixedTime, Scheme>(m, "FixedTime", R"(One package per period of event time.

A package holds the events before the next multiple of the period. Flushed when the oldest event has
waited for the latency bound.

Parameters
----------
period_ms : float
    At least 0.001 ms.
)")
      .def(py::init([](double period_ms) { return FixedTime({.period_ms = period_ms}); }),
           py::kw_only(), py::arg("period_ms") = 1.0);

  py::class_<SingleEvent, Scheme>(m, "SingleEvent", "Every event is a package of its own.")
      .def(py::init<>());

  py::class_<Greedy, Scheme>(m, "Greedy", "All that waits, whenever the algorithm is free.")
      .def(py::init<>());

  py::class_<Asap2020, Scheme>(m, "Asap2020", R"(The scheme of the paper (Tapia et al., 2020).

The package size follows the processing time, so that it equals the package's span less a margin; gamma
falls when the filtered rate R exceeds the rate bound. Flushed when the oldest event has waited for the
latency bound. The R of a package of a few events is noise: with a fast algorithm, which gets small
packages, choose a min_size of 20 or more.

Parameters
----------
rate_bound : float
    a, events/s after the gamma filter above which gamma falls.
epsilon : float
    Margin: processing time = (1 - epsilon) span. 0 <= epsilon < 1.
first_size, max_size, min_size : int
    First, largest and least package size, in kept events.
)")
      .def(py::init([](double rate_bound, double epsilon, const py::object& first_size,
                       const py::object& max_size, const py::object& min_size) {
             return Asap2020({.rate_bound = rate_bound,
                              .epsilon = epsilon,
                              .first_size = whole_number("first_size", first_size),
                              .max_size = whole_number("max_size", max_size),
                              .min_size = whole_number("min_size", min_size)});
           }),
           py::kw_only(), py::arg("rate_bound") = 5e6, py::arg("epsilon") = 0.05,
           py::arg("first_size") = 1000, py::arg("max_size") = 50'000, py::arg("min_size") = 1);
}

}  // namespace asap::python
