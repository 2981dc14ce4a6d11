// The layer `runner`: simulated algorithm, virtual time, real time. Python drives them chunk by
// chunk (asap.experiment); the loops themselves run natively, without the GIL.
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/runner/replay.hpp"
#include "asap/runner/simulator.hpp"
#include "callbacks.hpp"
#include "core/check.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "keywords.hpp"
#include "runner/read_ahead.hpp"
#include "telemetry.hpp"

namespace asap::python::runner {
namespace {

template <class Runner>
py::object kept_arrays(const Runner& runner) {
  const std::optional<KeptEvents> reading = without_gil([&] { return runner.kept(); });
  if (!reading) return py::none();
  const auto size = static_cast<py::ssize_t>(reading->kept.size());
  py::array_t<bool> kept(size);
  std::copy(reading->kept.begin(), reading->kept.end(), kept.mutable_data());
  const auto packages = static_cast<py::ssize_t>(reading->first.size());
  py::array_t<std::int64_t> first(packages, reading->first.data());
  for (const py::array& array : {py::array(kept), py::array(first)}) {
    array.attr("flags").attr("writeable") = false;
  }
  return py::make_tuple(kept, first);
}

template <class Runner, class Class>
void bind_results(Class& cls) {
  cls.def_property_readonly(
         "ledger", [](const Runner& runner) { return dict_of(runner.ledger()); },
         "Where every event went, in events.")
      .def_property_readonly(
          "validator", [](const Runner& runner) { return runner.validator(); },
          "What was rejected or repaired at the door.")
      .def_property_readonly(
          "packages", [](const Runner& runner) { return rows_of(runner.log()); },
          "One row per package, in PACKAGE_DTYPE: a read-only copy.")
      .def_property_readonly(
          "latency", [](const Runner& runner) { return runner.stats().latency; },
          "Latency per delivered event (a copy).")
      .def_property_readonly(
          "gap_us", [](const Runner& runner) { return runner.stats().gap_us; },
          "The longest time between two delivered events in a row of which some "
          "between were lost, us.")
      .def_property_readonly(
          "kept_mask", [](const Runner& runner) { return kept_arrays(runner); },
          "With keep_mask: of every received event, delivered or not; of every package, its "
          "first.");
}

using Times = std::vector<std::pair<double, double>>;

// A sequence, or None for an empty one.
template <class Value>
Value sequence(const char* name, py::handle given, const char* remedy) {
  try {
    return given.is_none() ? Value() : given.cast<Value>();
  } catch (const py::cast_error&) {
    throw_wrong_kind(name, given, remedy);
  }
}

template <class Value>
py::object or_none(const Value& values) {
  return values.empty() ? py::none() : py::cast(values);
}

Keyword<LinearCostConfig> drift() {
  return keyword<LinearCostConfig>(
      "drift",
      [](LinearCostConfig& config, py::handle given) {
        config.drift = sequence<std::vector<double>>("drift", given, "give a sequence of numbers");
      },
      [](const LinearCostConfig& config) { return or_none(config.drift); });
}

Keyword<LinearCostConfig> outages() {
  constexpr double kLargestMs = 9e12;
  return keyword<LinearCostConfig>(
      "outages_ms",
      [](LinearCostConfig& config, py::handle given) {
        const auto times =
            sequence<Times>("outages_ms", given, "give a sequence of (begin, end) in ms");
        for (const auto& [begin_ms, end_ms] : times) {
          require(std::abs(begin_ms) <= kLargestMs && std::abs(end_ms) <= kLargestMs, "outages_ms",
                  begin_ms, "give begin and end in ms");
          config.outages.push_back({std::llround(begin_ms * 1e6), std::llround(end_ms * 1e6)});
        }
      },
      [](const LinearCostConfig& config) {
        Times times;
        for (const Outage& outage : config.outages) {
          times.emplace_back(static_cast<double>(outage.begin_ns) * 1e-6,
                             static_cast<double>(outage.end_ns) * 1e-6);
        }
        return or_none(times);
      });
}

Keywords<LinearCostConfig> cost_keywords() {
  using Config = LinearCostConfig;
  return {2,
          {keyword("alpha_us", &Config::alpha_us), keyword("beta_ns", &Config::beta_ns),
           keyword("noise", &Config::noise), keyword("seed", &Config::seed), drift(), outages()}};
}

// A LinearCost, or the caller's function of n and t_us; destroyed with the simulator, which happens
// while the GIL is held.
SimulatedCost cost_of(const py::object& cost) {
  if (py::isinstance<LinearCost>(cost)) return *cost.cast<Held<LinearCost>>();
  return [function = std::make_shared<py::object>(cost)](std::size_t n, double t_us) {
    const std::string call =
        "cost(" + std::to_string(n) + ", " + std::to_string(std::llround(t_us)) + ")";
    return with_gil([&] { return real_number(call.c_str(), (*function)(n, t_us)); });
  };
}

constexpr Choices<WhenFull, 4> kWhenFull{{{"thin", WhenFull::thin},
                                          {"keep_oldest", WhenFull::keep_oldest},
                                          {"keep_newest", WhenFull::keep_newest},
                                          {"block", WhenFull::block}}};

// What Python gives as an object and never reads back.
template <class Take>
Keyword<RunConfig> taken(const char* name, Take take) {
  return keyword<RunConfig>(
      name,
      [=](RunConfig& config, py::handle given) {
        take(config, py::reinterpret_borrow<py::object>(given));
      },
      [](const RunConfig&) { return py::none(); });
}

Keywords<RunConfig> run_keywords() {
  using Config = RunConfig;
  return {0,
          {keyword("latency_ms", &Config::latency), keyword("capacity", &Config::capacity),
           keyword("seed", &Config::seed),
           taken("validator",
                 [](Config& config, const py::object& given) {
                   config.validator = given.cast<const Validator&>().config();
                 }),
           keyword("execution", &Config::execution, kExecutions), keyword("flush", &Config::flush),
           taken("before",
                 [](Config& config, const py::object& given) {
                   config.front_filter = front_filter_of(given);
                 }),
           keyword("when_full", &Config::when_full, kWhenFull),
           keyword("keep_mask", &Config::keep_mask), keyword("log_rows", &Config::log_rows)}};
}

// Ends a thread that replays while the interpreter exits, without a word.
[[noreturn]] void throw_system_exit() {
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

// A run without the GIL; `poll` is called with it.
void replay_source(Replay& replay, EventSource& source, const py::object& algorithm,
                   const py::object& poll) {
  const Consumer consumer = consumer_of(algorithm);
  const Replay::Poll poll_python = [&] {
    with_gil([&] {
      if (is_exiting()) throw_system_exit();
      check_signals();
      if (!poll.is_none()) poll();
    });
  };
  const WithoutGil release;  // the producer's pace must not hang on Python
  replay.run(source, consumer, poll_python);
}

void bind_cost(py::module_& m) {
  Class<LinearCost> type(m, "LinearCost", R"(A simulated algorithm.

A package of n events costs X (alpha + beta n); X is lognormal of mean 1 with sigma = noise, one draw
per package. beta may drift, and outages stop the algorithm: it neither starts nor goes on.

Parameters
----------
alpha_us : float
    Fixed cost of a package, us.
beta_ns : float
    Cost of an event, ns.
noise : float
    Sigma of the logarithm; 0: none.
seed : int
    0 <= seed < 2**64.
drift : array_like, shape (n,), optional
    Factors on beta, one for each ms of the run; the last one stays. A run's time begins at the whole
    second before its first event.
outages_ms : array_like, shape (n, 2), optional
    Begin and end of each outage, ms of the run, in order.

Raises
------
ValueError
    A value out of range, or outages that overlap.

Examples
--------
>>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
>>> run = asap.simulate(scene, cost=asap.LinearCost(100, 300), latency_ms=10)
>>> int(run.packages["processing_us"].min()) >= 100
True
)");
  const auto keywords = cost_keywords();
  bind_constructor(type, keywords);
  type.def_property_readonly(
          "name", [](const LinearCost&) { return "linear_cost"; }, "Its name in reports.")
      .def_property_readonly(
          "parameters",
          [keywords](const LinearCost& cost) {
            py::dict all;
            for (const auto& [name, value] : told(keywords, &cost.config())) {
              if (!value.is_none()) all[name] = value;
            }
            return all;
          },
          "The constructor's arguments by name: us, ns, ms. Without drift and outages_ms where "
          "there are none.")
      .def("__reduce__",
           [](const py::object& self) {
             return reduced(self, py::type::of<LinearCost>(), self.attr("parameters"));
           })
      .def("__repr__", [](const LinearCost& cost) {
        return py::str("LinearCost(alpha_us={}, beta_ns={}, noise={}, seed={})")
            .format(cost.config().alpha_us, cost.config().beta_ns, cost.config().noise,
                    cost.config().seed);
      });
}

}  // namespace

void bind(py::module_& m) {
  m.def("is_native", &is_native, py::arg("algorithm"),
        "Whether the library owns the algorithm's loop over the events of a package.");

  bind_cost(m);

  m.def(
      "checked_latency_ms",
      [](const py::object& latency_ms) {
        const auto latency = time_of_ms("latency_ms", latency_ms);
        return ms_of(std::chrono::nanoseconds(checked_latency_ns(latency)));
      },
      py::arg("latency_ms"), "The latency bound to the ns; ValueError for one out of range.");

  Class<RunConfig> type(m, "RunConfig", "What the runners have in common.");
  bind_constructor(type, run_keywords());
  type.def(
          "latency_bound_us",
          [](const RunConfig& one, const Held<Scheme>& scheme) {
            return static_cast<double>(latency_bound_ns(one, *scheme)) * 1e-3;
          },
          py::arg("scheme"), "The latency bound in force, us.")
      .def_property_readonly("seed", [](const RunConfig& one) { return one.seed; })
      .def_property_readonly("keep_mask", [](const RunConfig& one) { return one.keep_mask; })
      .def_property_readonly(
          "execution", [](const RunConfig& one) { return name_in(kExecutions, one.execution); });

  auto simulator =
      py::class_<Simulator>(m, "Simulator", "A run in virtual time, fed chunk by chunk.");
  simulator
      .def(py::init([](const Held<Scheme>& scheme, const py::object& cost, const RunConfig& config,
                       const py::object& algorithm, const py::object& speed) {
             return std::make_unique<Simulator>(*scheme, cost_of(cost), config,
                                                consumer_of(algorithm),
                                                real_number("speed", speed));
           }),
           py::arg("scheme"), py::arg("cost"), py::arg("config"), py::arg("algorithm") = py::none(),
           py::arg("speed") = 1.0, py::keep_alive<1, 2>(), py::keep_alive<1, 5>())
      .def("feed", &feed_unheld<Simulator>, py::arg("events").noconvert(),
           "Events in arrival order; runs as far as they allow.")
      .def(
          "finish", [](Simulator& self) { without_gil([&] { self.finish(); }); },
          "No event follows: what waits is delivered.")
      .def_property_readonly(
          "slots", [](const Simulator& self) { return rows_of(self.slots()); },
          "One row per 1 ms of timestamps that holds an event, in SLOT_DTYPE: a read-only copy.");
  bind_results<Simulator>(simulator);

  py::class_<ReadAhead>(m, "ReadAhead", "Decouples the paced producer from the reader of a source.")
      .def(py::init<>())
      .def("feed", &feed_unheld<ReadAhead>, py::arg("events").noconvert(),
           "Blocks while full; False: cancelled, stop reading.")
      .def("finish", &ReadAhead::finish, "No feed follows.")
      .def("cancel", &ReadAhead::cancel, "Feeds and the producer stop waiting.");

  auto replay = py::class_<Replay>(m, "Replay", "A recording paced in real time.");
  replay
      .def(py::init(
               [](const Held<Scheme>& scheme, const RunConfig& config, const py::object& speed) {
                 return std::make_unique<Replay>(
                     *scheme, ReplayConfig{.speed = real_number("speed", speed)}, config);
               }),
           py::arg("scheme"), py::arg("config"), py::arg("speed") = 1.0, py::keep_alive<1, 2>())
      .def(
          "run",
          [](Replay& self, const py::array& events, const py::object& algorithm,
             const py::object& poll) {
            SpanSource source(as_span(events));
            replay_source(self, source, algorithm, poll);
          },
          py::arg("events").noconvert(), py::arg("algorithm"), py::arg("poll") = py::none(),
          "Replays an array; the algorithm runs on this thread.")
      .def(
          "run",
          [](Replay& self, ReadAhead& source, const py::object& algorithm, const py::object& poll) {
            replay_source(self, source, algorithm, poll);
          },
          py::arg("source"), py::arg("algorithm"), py::arg("poll") = py::none(),
          "Replays what a reader's thread feeds.")
      .def_property_readonly(
          "lateness", [](const Replay& self) { return self.lateness(); },
          "How late the producer pushed, us: its own and the machine's jitter, per push.");
  bind_results<Replay>(replay);
}

}  // namespace asap::python::runner
