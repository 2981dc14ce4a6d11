#include "per_event.hpp"

#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <utility>

namespace asap::python {
namespace {

// The object of a call from Python, in its turn.
struct Worker {
  Worker(Open open, const py::object& self, bool works = true)
      : inside(open(self)), turn(inside->turns) {
    inside->has_worked |= works;
  }

  void* get() const noexcept { return inside->object.get(); }

  std::shared_ptr<Inside> inside;
  CallersTurn turn;
};

template <class Process, class... Extra>
void def_process(const py::object& type, Process process, const char* returns,
                 const Extra&... extra) {
  def_method(type, "process", std::move(process), py::arg("events").noconvert(), extra...,
             process_doc(returns, sizeof...(extra) > 0).c_str());
}

}  // namespace

std::string documented(const std::string& given) {
  std::string text = given;
  constexpr std::pair<const char*, const char*> kTexts[] = {
      {"$sensor", R"(Parameters
----------
width, height : int
    Size of the sensor, px, 1 to 16384. Events outside are dropped and counted in `rejected`)"},
      {"$scene", R"(Examples
--------
>>> scene = asap.synthetic.FlightOverChairs(duration_s=0.05)
>>> events = scene.events())"},
      {"$costs", R"(Examples
--------
>>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
>>> cost = asap.LinearCost(100, 300))"},
      {"$refuses", R"(Raises
------
ValueError
    A parameter is out of range; the message names it.)"},
      {"$learned", R"(Attributes
----------
alpha_us, beta_ns : float
    Present cost of a package and of an event, as measured.)"},
      {"$outline", R"(Returns
-------
numpy.void
    A row with the float64 fields x, y (px, centre), major, minor (px, half-axes) and angle (rad, of the
    major axis, from x to the right towards y downwards, -pi/2 to pi/2).

Raises
------
KeyError
    There is no such id now.)"},
      {"$not_gamma", R"(Raises
------
ValueError
    gamma is NaN or outside [0, 1].)"},
  };
  for (const auto& [word, meaning] : kTexts) {
    const std::size_t at = text.find(word);
    if (at != std::string::npos) text.replace(at, std::string(word).size(), meaning);
  }
  return text;
}

std::string process_doc(const char* returns, bool has_labels) {
  std::string text = R"(Takes the next events of the stream.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE
)";
  if (has_labels) text += "labels : bool\n    False: no array is made.\n";
  if (returns != nullptr) text.append("\nReturns\n-------\n").append(returns).append("\n");
  return text + R"(
Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.
)";
}

void def_taking(const py::object& type, const NativeAlgorithm& calls) {
  const auto process = [calls](const py::object& self, const py::object& events) {
    const EventSpan span = as_span(events);
    const Worker worker(calls.open, self);
    without_gil([&] { calls.process(worker.get(), span); });
  };
  def_process(type, process, nullptr);
}

void def_passing(const py::object& type, const NativeAlgorithm& calls) {
  const auto process = [calls](const py::object& self, const py::object& events) {
    const EventSpan span = as_span(events);
    std::vector<Event> passed(span.size());
    const Worker worker(calls.open, self);
    without_gil([&] { passed.resize(calls.pass(worker.get(), span, passed)); });
    return moved_to_array(std::move(passed));
  };
  def_process(type, process,
              "ndarray of shape (k,) in EVENT_DTYPE\n    Those that pass: a new array.");
}

void def_labelled(const py::object& type, const NativeAlgorithm& calls, Label label,
                  const char* returns) {
  const auto process = [calls, label](const py::object& self, const py::object& events,
                                      bool labels) -> std::optional<py::array_t<std::int32_t>> {
    const EventSpan span = as_span(events);
    std::vector<std::int32_t> ids(labels ? span.size() : 0);
    const Worker worker(calls.open, self);
    without_gil(
        [&] { labels ? label(worker.get(), span, ids) : calls.process(worker.get(), span); });
    if (!labels) return std::nullopt;
    return moved_to_array(std::move(ids));
  };
  def_process(type, process, returns, py::arg("labels") = true);
}

void def_answering(const py::object& type, Open open, Answer answer, const py::dtype& dtype,
                   std::size_t columns, const char* returns) {
  const auto process = [=](const py::object& self, const py::object& events) {
    const EventSpan span = as_span(events);
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(span.size())};
    if (columns > 1) shape.push_back(static_cast<py::ssize_t>(columns));
    py::array values(dtype, shape);
    const Worker worker(open, self);
    without_gil([&] { answer(worker.get(), span, values.mutable_data()); });
    return values;
  };
  def_process(type, process, returns);
}

void def_rest(const py::object& type, const char* name, const NativeAlgorithm& calls,
              const char* gamma) {
  note_native(type, calls);
  type.attr("name") = name;
  def_method(
      type, "reset",
      [calls](const py::object& self) {
        const Worker worker(calls.open, self, false);
        calls.reset(worker.get());
        worker.inside->has_worked = false;
      },
      "Back to the state after construction: the same events, the same "
      "results.");
  if (gamma != nullptr) {
    def_method(
        type, "set_gamma",
        [calls](const py::object& self, double fraction) {
          const Worker worker(calls.open, self);
          calls.set_gamma(worker.get(), fraction);
        },
        py::arg("gamma"),
        documented("Tells the fraction of the events that reaches it, 0 <= gamma <= 1.\n\n" +
                   std::string(gamma) + "\n\n$not_gamma\n")
            .c_str());
  }
  def_property(type, "rejected", py::cpp_function([calls](const py::object& self) {
                 const Worker worker(calls.open, self, false);
                 return calls.rejected(worker.get());
               }),
               "Events dropped because they lie outside the frame.");
}

}  // namespace asap::python
