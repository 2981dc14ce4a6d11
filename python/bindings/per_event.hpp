// What every event-by-event algorithm has in Python besides its constructor and process.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "gil.hpp"
#include "pickles.hpp"
#include "turns.hpp"

namespace asap::python {

namespace py = pybind11;

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

// process() of an algorithm that lets some of the events pass.
template <class Filter>
void bind_passing(py::class_<Filter>& type) {
  const auto passing = [](Filter& filter, const py::array& events) {
    const EventSpan span = as_span(events);
    std::vector<Event> passed(span.size());
    {
      // Pure C++ on memory that `events` keeps alive: other Python threads may run.
      const WithoutGil release;
      passed.resize(filter.process(span, passed.data()));
    }
    return moved_to_array(std::move(passed));
  };
  type.def("process", passing, py::arg("events").noconvert(),
           R"(Takes the next events of the stream and returns those that pass.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE

Returns
-------
ndarray of shape (k,) in EVENT_DTYPE
    A new array.

Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.
)");
}

// An algorithm pickles while it is new.
template <class Algorithm>
py::class_<Algorithm>& bind_pickle(py::class_<Algorithm>& type) {
  return type.def("__reduce__", [](const py::object& self) {
    if (has_worked(self)) throw_has_worked(self);
    return by_arguments(self, py::type::of<Algorithm>(), {"width", "height"});
  });
}

// `parameters` makes the dict of the constructor's keyword parameters.
template <class Algorithm>
void bind_rest(py::class_<Algorithm>& type, const char* name,
               py::dict (*parameters)(const typename Algorithm::Config&), const char* keep_doc) {
  bind_pickle(type);
  type.def("set_keep", &Algorithm::set_keep, py::arg("gamma"), keep_doc)
      .def("reset", &Algorithm::reset, "Back to the state after construction.")
      .def_property_readonly(
          "width", [](const Algorithm& self) { return self.config().width; }, "px")
      .def_property_readonly(
          "height", [](const Algorithm& self) { return self.config().height; }, "px")
      .def_property_readonly(
          "name", [name](const Algorithm&) { return name; }, "Name of the algorithm in reports.")
      .def_property_readonly(
          "parameters", [parameters](const Algorithm& self) { return parameters(self.config()); },
          "dict of the constructor's keyword parameters.")
      .def_property_readonly("rejected", &Algorithm::rejected,
                             "Events dropped because they lie outside the frame.");
}

}  // namespace asap::python
