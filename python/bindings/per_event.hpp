// What every event-by-event algorithm has in Python besides its constructor and process.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "keywords.hpp"

namespace asap::python {

namespace py = pybind11;

// The docstring whose words in $ stand for what all of them say alike.
std::string documented(std::string text);

// process(events), whose docstring the words in $ complete.
template <class T, class Process, class... Extra>
void bind_process(Class<T>& type, Process process, const char* doc, const Extra&... extra) {
  type.def("process", process, py::arg("events").noconvert(), extra..., documented(doc).c_str());
}

// process() of a tracker that gives every event an id. `labels` false: no array is made.
template <class Tracker>
std::optional<py::array_t<std::int32_t>> process_labelled(Tracker& tracker, const py::array& events,
                                                          bool labels) {
  const EventSpan span = as_span(events);
  std::vector<std::int32_t> ids(labels ? span.size() : 0);
  {
    // Pure C++ on memory that `events` keeps alive: other Python threads may run.
    const WithoutGil release;
    if (labels) {
      tracker.process(span, ids);
    } else {
      tracker.process(span);
    }
  }
  if (!labels) return std::nullopt;
  return moved_to_array(std::move(ids));
}

// process() of an algorithm that gives every event a Value, in NumPy one or more Elements.
template <class Element, class Value, class Algorithm>
py::array_t<Element> process_each(Algorithm& algorithm, const py::array& events) {
  const EventSpan span = as_span(events);
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(span.size())};
  if (sizeof(Value) > sizeof(Element)) shape.push_back(sizeof(Value) / sizeof(Element));
  py::array_t<Element> values(shape);
  auto* out = reinterpret_cast<Value*>(values.mutable_data());
  {
    // Pure C++ on memory that `events` keeps alive: other Python threads may run.
    const WithoutGil release;
    algorithm.process(span, {out, span.size()});
  }
  return values;
}

// process() of an algorithm that lets some of the events pass.
template <class Filter>
void bind_passing(Class<Filter>& type) {
  const auto passing = [](Filter& filter, const py::array& events) {
    const EventSpan span = as_span(events);
    std::vector<Event> passed(span.size());
    {
      // Pure C++ on memory that `events` keeps alive: other Python threads may run.
      const WithoutGil release;
      passed.resize(filter.process(span, passed));
    }
    return moved_to_array(std::move(passed));
  };
  bind_process(type, passing, R"(Takes the next events of the stream and returns those that pass.

$events

Returns
-------
ndarray of shape (k,) in EVENT_DTYPE
    A new array.

$not_events
)");
}

// After it the object is as new.
template <class T>
void bind_reset(Class<T>& type, const char* doc) {
  type.def(
      "reset",
      [](const Held<T>& self) {
        const CallersTurn turn(self.turns());
        self->reset();
        self.has_worked() = false;
      },
      doc);
}

// What the constructor's arguments tell of an object: .parameters, the repr, and the pickle of one
// that is new. `arguments(object, from)` makes the dict of them, from one on.
template <class T, class Arguments>
void bind_arguments(Class<T>& type, Arguments arguments, const py::dict& defaults,
                    std::size_t by_position) {
  type.def_property_readonly(
          "parameters", [=](const T& self) { return arguments(self, by_position); },
          "dict of the constructor's keyword parameters.")
      .def("__repr__",
           [=](const py::object& self) {
             return repr_of(self, arguments(*self.cast<Held<T>>(), 0), defaults, by_position);
           })
      .def("__reduce__", [=](const py::object& self) {
        const auto held = self.cast<Held<T>>();
        const CallersTurn turn(held.turns());
        if (held.has_worked()) throw_has_worked(self);
        return reduced(self, py::type::of<T>(), arguments(*held, 0));
      });
}

// All that the table of the constructor's arguments gives to a class.
template <class T, class Config>
void bind_configuration(Class<T>& type, const Keywords<Config>& keywords) {
  bind_constructor(type, keywords);
  bind_arguments(
      type, [=](const T& self, std::size_t from) { return told(keywords, self.config(), from); },
      told(keywords, Config{}), keywords.by_position);
}

template <class Algorithm, class... Extra>
void bind_rest(Class<Algorithm>& type, const char* name,
               const Keywords<typename Algorithm::Config>& keywords, const char* gamma_doc,
               const Extra&... extra) {
  bind_configuration(type, keywords);
  bind_reset(type, "Back to the state after construction.");
  type.def("set_gamma", &Algorithm::set_gamma, py::arg("gamma"), extra...,
           documented(gamma_doc).c_str())
      .def_property_readonly(
          "width", [](const Algorithm& self) { return self.config().width; }, "px")
      .def_property_readonly(
          "height", [](const Algorithm& self) { return self.config().height; }, "px")
      .def_property_readonly(
          "name", [name](const Algorithm&) { return name; }, "Name of the algorithm in reports.")
      .def_property_readonly("rejected", &Algorithm::rejected,
                             "Events dropped because they lie outside the frame.");
}

}  // namespace asap::python
