#include "arrays.hpp"

#include <pybind11/gil_safe_call_once.h>

#include "arguments.hpp"

namespace asap::python {

namespace {

py::handle plain_type() {
  PYBIND11_CONSTINIT static py::gil_safe_call_once_and_store<py::object> storage;
  return storage
      .call_once_and_store_result([] { return py::module_::import("numpy").attr("ndarray"); })
      .get_stored();
}

// Its memory alone would not tell what the mask hides.
bool has_mask(const py::array& events) {
  if (py::type::handle_of(events).is(plain_type())) return false;
  return py::isinstance(events, py::module_::import("numpy.ma").attr("MaskedArray"));
}

}  // namespace

py::dtype aligned_dtype(std::initializer_list<std::pair<const char*, const char*>> fields) {
  py::list listed;
  for (const auto& [name, kind] : fields) listed.append(py::make_tuple(name, kind));
  return py::module_::import("numpy").attr("dtype")(listed, py::arg("align") = true);
}

py::dtype event_dtype() {
  PYBIND11_CONSTINIT static py::gil_safe_call_once_and_store<py::dtype> storage;
  return storage
      .call_once_and_store_result(
          [] { return aligned_dtype({{"x", "<u2"}, {"y", "<u2"}, {"p", "<i2"}, {"t", "<i8"}}); })
      .get_stored();
}

EventSpan as_span(const py::array& events) {
  const bool masked = has_mask(events);
  const bool fits = !masked && events.ndim() == 1 && events.dtype().equal(event_dtype()) &&
                    (events.flags() & py::array::c_style) != 0 &&
                    reinterpret_cast<std::uintptr_t>(events.data()) % alignof(Event) == 0;
  if (!fits) {
    const auto shape = py::cast<std::string>(py::str(events.attr("shape")));
    const auto dtype = py::cast<std::string>(py::str(events.dtype()));
    throw py::type_error((masked ? "events = masked array of shape " : "events = array of shape ") +
                         shape + ", " + dtype + ": " + kGiveEvents);
  }
  return {static_cast<const Event*>(events.data()), static_cast<std::size_t>(events.size())};
}

EventSpan as_span(const py::object& events) {
  if (!py::isinstance<py::array>(events)) throw_wrong_kind("events", events, kGiveEvents);
  return as_span(py::reinterpret_borrow<py::array>(events));
}

std::span<Event> as_writable_span(const py::array& out) {
  const EventSpan events = as_span(out);
  if (!out.writeable()) throw py::value_error("out = read-only array: give a writable one");
  return {const_cast<Event*>(events.data()), events.size()};
}

py::array view_of(EventSpan events, py::handle owner) {
  py::array view(event_dtype(), {static_cast<py::ssize_t>(events.size())},
                 {static_cast<py::ssize_t>(sizeof(Event))}, events.data(), owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

}  // namespace asap::python
