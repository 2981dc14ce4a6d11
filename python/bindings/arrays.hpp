// Event arrays between NumPy and the core, without a copy.
//
// In: an array is taken only if its dtype is EVENT_DTYPE, C-contiguous and aligned; anything else
// is a TypeError, because a cast between structured types would scramble the columns silently
// (asap.as_events converts by field name).
// Out: a read-only view that keeps its owner alive, or a vector moved into the array.
#pragma once

#include <pybind11/numpy.h>

#include <initializer_list>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "asap/core/event.hpp"
#include "gil.hpp"

namespace asap::python {

namespace py = pybind11;

// asap.EVENT_DTYPE: {x <u2, y <u2, p <i2, t <i8}, offsets 0 2 4 8, 16 bytes, aligned. (Without the
// aligned flag, which py::dtype::of<> lacks, np.concatenate would pack it to 14 bytes.)
py::dtype event_dtype();

// An aligned dtype of these fields, by name and kind.
py::dtype aligned_dtype(std::initializer_list<std::pair<const char*, const char*>> fields);

// The remedy where something else is given.
constexpr const char* kGiveEvents =
    "give a contiguous one-dimensional array in asap.EVENT_DTYPE; asap.as_events(...) makes one";

// The events of an array in EVENT_DTYPE; valid while the array lives.
EventSpan as_span(const py::array& events);
EventSpan as_span(const py::object& events);

// The events of a writable array in EVENT_DTYPE, to be filled.
std::span<Event> as_writable_span(const py::array& out);

// A read-only array over memory that `owner` keeps alive.
py::array view_of(EventSpan events, py::handle owner);

// T::feed with an array of events, without the GIL: it may block, and a Python algorithm takes it
// back for its packages.
template <class T>
auto feed_unheld(T& self, const py::array& events) {
  const EventSpan span = as_span(events);
  return without_gil([&] { return self.feed(span); });
}

// An array that owns the vector's memory.
template <class Value>
py::array moved_to_array(std::vector<Value> values, const py::dtype& dtype) {
  auto owned = std::make_unique<std::vector<Value>>(std::move(values));
  const auto* data = owned->data();
  const auto size = static_cast<py::ssize_t>(owned->size());
  py::capsule owner(owned.release(),
                    [](void* pointer) { delete static_cast<std::vector<Value>*>(pointer); });
  return py::array(dtype, {size}, {static_cast<py::ssize_t>(sizeof(Value))}, data, owner);
}

template <class Value>
py::array_t<Value> moved_to_array(std::vector<Value> values) {
  return moved_to_array(std::move(values), py::dtype::of<Value>());
}

inline py::array moved_to_array(std::vector<Event> events) {
  return moved_to_array(std::move(events), event_dtype());
}

}  // namespace asap::python
