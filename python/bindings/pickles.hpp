// Pickles: an object goes as its type and its constructor's arguments, in every protocol.
#pragma once

#include <pybind11/pybind11.h>

#include <initializer_list>
#include <string>

namespace asap::python {

// The value of __reduce__: the attributes of these names by position, .parameters by keyword. A
// class derived in Python may hold more than that and is refused.
inline pybind11::tuple by_arguments(const pybind11::object& made, const pybind11::type& type,
                                    std::initializer_list<const char*> by_position = {}) {
  namespace py = pybind11;
  const py::type own = py::type::of(made);
  if (!own.is(type)) {
    throw py::type_error("cannot pickle " + py::cast<std::string>(own.attr("__name__")) +
                         ": it is derived from " + py::cast<std::string>(type.attr("__name__")) +
                         "; give it a __reduce__");
  }
  py::list arguments;
  for (const char* name : by_position) arguments.append(made.attr(name));
  const py::object partial = py::module_::import("functools").attr("partial");
  return py::make_tuple(partial(type, *arguments, **py::dict(made.attr("parameters"))),
                        py::tuple());
}

// The refusal of an object whose arguments no longer tell all of it.
[[noreturn]] inline void throw_has_worked(const pybind11::object& made) {
  namespace py = pybind11;
  throw py::type_error("cannot pickle " +
                       py::cast<std::string>(py::type::of(made).attr("__name__")) +
                       ": it has worked, and what events have left in it stays in it; pickle its "
                       "results, or a new one");
}

}  // namespace asap::python
