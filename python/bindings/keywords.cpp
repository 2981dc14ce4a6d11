#include "keywords.hpp"

#include <algorithm>

namespace asap::python {
namespace {

namespace py = pybind11;

// A name from Python; one that has no UTF-8 is escaped.
std::string text_of(py::handle name) {
  if (const char* text = PyUnicode_AsUTF8(name.ptr())) return text;
  PyErr_Clear();
  const auto escaped = py::reinterpret_steal<py::str>(PyObject_ASCII(name.ptr()));
  return py::cast<std::string>(escaped);
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "it takes " : ", ") + name;
  return text.empty() ? "it takes none" : text;
}

std::string near(const std::string& name, const std::vector<std::string>& names) {
  const py::list found =
      py::module_::import("difflib").attr("get_close_matches")(name, names, py::arg("n") = 1);
  return found.empty() ? "" : "did you mean " + py::cast<std::string>(found[0]) + "? ";
}

}  // namespace

py::dict by_name(const std::string& owner, const std::vector<std::string>& names,
                 std::size_t by_position, const py::args& values, const py::kwargs& given) {
  if (values.size() > by_position) {
    throw py::type_error(shown(values[by_position]) + ": " + owner + " takes " +
                         (by_position == 0 ? "no" : "no further") + " value without its name; " +
                         listed(names));
  }
  py::dict all;
  for (std::size_t i = 0; i < values.size(); ++i) all[names[i].c_str()] = values[i];
  for (const auto& [key, value] : given) {
    const std::string name = text_of(key);
    if (std::ranges::find(names, name) == names.end()) {
      throw py::type_error(name + " = " + shown(value) + ": " + owner + " has no such parameter; " +
                           near(name, names) + listed(names));
    }
    if (all.contains(key)) throw_wrong_kind(name.c_str(), value, "given by position already");
    all[key] = value;
  }
  for (std::size_t i = 0; i < by_position; ++i) {
    if (all.contains(names[i])) continue;
    throw py::type_error(names[i] + " is missing: " + owner + " needs it; " + listed(names));
  }
  return all;
}

std::string signature_of(const py::dict& defaults, std::size_t by_position) {
  std::string text = "__init__(self";
  std::size_t place = 0;
  for (const auto& [name, value] : defaults) {
    if (place == by_position) text += ", *";
    text += ", " + py::cast<std::string>(name);
    if (place++ >= by_position) text += "=" + py::cast<std::string>(py::repr(value));
  }
  return text + ")\n--\n\n";
}

std::string repr_of(const py::handle& made, const py::dict& arguments, const py::dict& defaults,
                    std::size_t by_position) {
  py::list given;
  std::size_t place = 0;
  for (const auto& [name, value] : arguments) {
    const auto text = py::cast<std::string>(py::repr(value));
    if (place++ < by_position) {
      given.append(text);
    } else if (!value.equal(defaults[name])) {
      given.append(py::cast<std::string>(name) + "=" + text);
    }
  }
  return py::cast<std::string>(py::type::of(made).attr("__name__")) + "(" +
         py::cast<std::string>(py::str(", ").attr("join")(given)) + ")";
}

py::tuple reduced(const py::handle& made, const py::handle& type, const py::dict& arguments) {
  const auto own = py::type::of(made);
  if (!own.is(type)) {
    throw py::type_error("cannot pickle " + py::cast<std::string>(own.attr("__name__")) +
                         ": it is derived from " + py::cast<std::string>(type.attr("__name__")) +
                         "; give it a __reduce__");
  }
  const py::object partial = py::module_::import("functools").attr("partial");
  return py::make_tuple(partial(type, **arguments), py::tuple());
}

void throw_has_worked(const py::handle& made) {
  throw py::type_error("cannot pickle " +
                       py::cast<std::string>(py::type::of(made).attr("__name__")) +
                       ": it has worked, and what events have left in it stays in it; pickle its "
                       "results, or a new one");
}

}  // namespace asap::python
