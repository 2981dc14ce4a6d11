// The layer `schemes`: the schemes that a user chooses from, one row each: class, name, docstring.
// The keywords of the constructor, their defaults and .parameters come from kParameters of its
// configuration.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <tuple>

#include "arguments.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "asap/schemes/scheme.hpp"
#include "held.hpp"
#include "keywords.hpp"
#include "per_event.hpp"

namespace asap::python::schemes {
namespace {

// The values by name, as far as the scheme tells them.
py::dict scheme_parameters(const Scheme& scheme) {
  py::dict result;
  for (const auto& [name, value] : scheme.parameters()) {
    result[py::str(name)] = py::cast(value);
  }
  return result;
}

template <class S>
void bind_cost(Class<S, Scheme>& bound) {
  bound
      .def_property_readonly(
          "alpha_us", [](const S& scheme) { return scheme.alpha_ns() * 1e-3; },
          "Fixed cost of a package at present, as measured, us.")
      .def_property_readonly("beta_ns", &S::beta_ns,
                             "Cost of an event at present, as measured, ns.");
}

template <class S>
auto keywords_of_scheme() {
  if constexpr (requires { S::Config::kParameters; }) {
    return std::apply(
        [](const auto&... fields) {
          return Keywords<typename S::Config>(0, {keyword(fields.name, fields.field)...});
        },
        S::Config::kParameters);
  } else {
    struct None {};
    return Keywords<None>(0, {});
  }
}

template <class S>
void bind_scheme(py::module_& m, const char* name, const char* doc) {
  Class<S, Scheme> bound(m, name, documented(doc).c_str());
  const auto keywords = keywords_of_scheme<S>();
  bind_constructor(bound, keywords);
  // A scheme leaves out what it has no value of.
  const auto parameters = [keywords](const S& scheme) {
    py::dict all;
    for (const auto& row : keywords.rows) all[row.name.c_str()] = py::none();
    all.attr("update")(scheme_parameters(scheme));
    return all;
  };
  bound.def_property_readonly("parameters", parameters, "The constructor's arguments by name.")
      .def("__reduce__", [](const py::object& self) {
        return reduced(self, py::type::of<S>(), self.attr("parameters"));
      });
  if constexpr (requires(const S& scheme) { scheme.alpha_ns(); }) bind_cost(bound);
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

void bind(py::module_& m) {
  translate_bad_times();
  Class<Scheme>(m, "Scheme",
                "Scheme(*args, **kwargs)\n--\n\n"  // none of its own
                "The rule that decides size and gamma of the next package.")
      .def_property_readonly("name", &Scheme::name, "Its name on the command line and in files.")
      .def_property_readonly("parameters", &scheme_parameters,
                             "The constructor's arguments by name.")
      .def("__repr__", &repr);

  bind_scheme<FixedSize>(m, "FixedSize", R"(Packages of a fixed number of events.

Flushed when the oldest event has waited for the latency bound.

Parameters
----------
size : int
    Events per package, at least 1.

$refuses

$costs
>>> run = asap.simulate(scene, cost=cost, scheme=asap.FixedSize(size=500), latency_ms=50)
>>> int(run.packages["size"].max())
500
)");

  bind_scheme<FixedTime>(m, "FixedTime", R"(One package per period of event time.

A package holds the events before the next multiple of the period. Flushed when the oldest event has
waited for the latency bound.

Parameters
----------
period_ms : float
    At least 0.001 ms.

$refuses

$costs
>>> run = asap.simulate(scene, cost=cost, scheme=asap.FixedTime(period_ms=5))
>>> len(run.packages)
20
)");

  bind_scheme<SingleEvent>(m, "SingleEvent", R"(Every event is a package of its own.

$costs
>>> run = asap.simulate(scene, cost=cost, scheme=asap.SingleEvent())
>>> int(run.packages["size"].max())
1
)");

  bind_scheme<Greedy>(m, "Greedy", R"(All that waits, whenever the algorithm is free.

Parameters
----------
efficiency : float, optional
    Share of a package's time that goes into its events, 0 < efficiency < 1: caps the package, oldest
    first, and the rest waits, which shortens the longest latency after abrupt changes. Keep it well
    above the mean load; 0.97 is a good one. None: no cap.

$refuses

$costs
>>> asap.simulate(scene, cost=cost, scheme=asap.Greedy(), latency_ms=10).kept
1.0
)");

  bind_scheme<Asap2020>(m, "Asap2020", R"(The scheme of the paper (Tapia et al., 2020).

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

$refuses

$costs
>>> scheme = asap.Asap2020(rate_bound=0.9e9 / 300)  # nine tenths of what the cost allows
>>> asap.simulate(scene, cost=cost, scheme=scheme, latency_ms=10).kept
1.0
)");

  bind_scheme<Asap2022>(m, "Asap2022",
                        R"(The scheme of the public node of Tapia et al., 2022: a baseline.

The package size is an arc tangent of the logarithm of the processing time in ms, from min_size at
min_processing_ms to max_size at max_processing_ms; it does not see the event rate and may have two
stable values. gamma falls as the rate of the driver's containers (1000 events or 20 ms) approaches its
largest recent value, and chatters at a constant rate. Flushed when the oldest event has waited for the
latency bound. The defaults suit an algorithm of 100 us per package and 300 ns per event, within 10 ms.

Parameters
----------
min_processing_ms, max_processing_ms : float
    Limits of the processing time.
min_size, max_size : int
    Package sizes at these limits, in kept events.
kappa : float
    Steepness of the size rule, positive.
min_gamma, max_gamma : float
    Range of gamma; 0 <= min_gamma <= max_gamma <= 1.
first_size : int
    Size before the first package is finished.

$refuses

$costs
>>> asap.simulate(scene, cost=cost, scheme=asap.Asap2022(), latency_ms=10).ledger.balanced
True
)");

  bind_scheme<Deadline>(m, "Deadline", R"(As many events as possible within a latency bound.

While the algorithm keeps up, nothing is discarded. In overload some ten plans are simulated on the
backlog, and the best is taken: events that are too old are dropped, the older part of the rest is thinned
so that it is finished in time, and the newest events stay in the buffer, unthinned. Where the library
runs the algorithm's loop, a package that takes longer than expected still ends on time. A package during
which the system takes the processor away is late.

Parameters
----------
latency_ms : float
    The bound L, from an event's timestamp to the end of its package. 0.01 to 1e7 ms.
overhead : float
    Permitted share of the processor for the fixed cost of packages; 0 = any. A small one makes
    fewer and larger packages, at the price of latency in quiet scenes.
min_interval_ms : float
    Shortest time between the starts of two packages.
first_alpha_us, first_beta_ns : float
    Assumed fixed cost of a package and cost of an event, until they are measured.
prefer : str
    In overload: "events", as many as possible; "continuity", short gaps, stretches of the scene
    without any; "balanced", between the two.

$learned

$refuses

Notes
-----
Source: notebooks/theory.md, section 6.

Examples
--------
>>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
>>> scheme = asap.Deadline(latency_ms=5, prefer="continuity")
>>> asap.simulate(scene, cost=asap.LinearCost(100, 300), scheme=scheme).in_time
1.0
)");

  bind_scheme<DeadBeat>(m, "DeadBeat", R"(The simplest scheme that keeps a latency bound.

Every package takes all that waits and is planned to last half the bound at most, so nothing that waits
is older than that. The rest is thinned evenly. Settles in one package. `Deadline` keeps more
of a short rush.

Parameters
----------
latency_ms : float
    The bound L, from an event's timestamp to the end of its package. 0.01 to 1e7 ms.
knee : float
    K: in overload no package is longer than K times its fixed cost, which keeps 1 - 1 / K of the
    throughput. 0 = off.
overhead : float
    Permitted share of the processor for the fixed cost of packages; 0 = any.
min_interval_ms : float
    Shortest time between the starts of two packages.

$learned

$refuses

Notes
-----
Source: notebooks/theory.md, section 5.

$costs
>>> asap.simulate(scene, cost=cost, scheme=asap.DeadBeat(latency_ms=5)).in_time
1.0
)");

  m.attr("SCHEMES") = py::tuple(m.attr("Scheme").attr("__subclasses__")());
}

}  // namespace asap::python::schemes
