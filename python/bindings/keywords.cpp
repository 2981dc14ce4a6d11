#include "keywords.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "asap/schemes/deadline.hpp"

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

// Nanoseconds are a number of ms in Python, another duration is a number of its own unit.
template <class Value>
concept Duration = requires { typename Value::period; };

template <class Value>
Value value_of(const char* name, py::handle given) {
  if constexpr (std::is_same_v<Value, std::optional<bool>>) {
    if (given.is_none()) return std::nullopt;
    try {
      return given.cast<bool>();
    } catch (const py::cast_error&) {
      throw_wrong_kind(name, given, "give True, False or None");
    }
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value_of<std::optional<bool>>(name, given).value_or(false);
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    return given.is_none() ? Value() : real_number(name, given);
  } else if constexpr (std::is_same_v<Value, std::optional<std::chrono::nanoseconds>>) {
    return given.is_none() ? Value() : time_of_ms(name, given);
  } else if constexpr (std::is_same_v<Value, std::chrono::nanoseconds>) {
    return time_of_ms(name, given);
  } else if constexpr (Duration<Value>) {
    return Value(value_of<typename Value::rep>(name, given));
  } else if constexpr (std::is_same_v<Value, Prefer>) {
    if (!py::isinstance<py::str>(given)) throw_wrong_kind(name, given, "give text");
    return prefer_of(given.cast<std::string>());
  } else if constexpr (std::is_integral_v<Value>) {
    return whole_number<Value>(name, given);
  } else {
    return real_number(name, given);
  }
}

template <class Value>
py::object object_of(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return py::cast(name_of(value));
  } else if constexpr (std::is_same_v<Value, std::chrono::nanoseconds>) {
    return py::cast(ms_of(value));
  } else if constexpr (Duration<Value>) {
    return py::cast(value.count());
  } else {
    return py::cast(value);
  }
}

// The values by name.
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

// "EFast(20, 10)": how to make an object anew, without what is a default.
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
  const py::object type = py::type::of(made);
  return py::cast<std::string>(type.attr("__name__")) + "(" +
         py::cast<std::string>(py::getattr(type, "_of", py::str())) +
         py::cast<std::string>(py::str(", ").attr("join")(given)) + ")";
}

}  // namespace

template <class Value>
Row row_of(const std::string& name, std::ptrdiff_t offset) {
  return {name,
          [=](void* config, py::handle given) {
            *reinterpret_cast<Value*>(static_cast<char*>(config) + offset) =
                value_of<Value>(name.c_str(), given);
          },
          [=](const void* config) {
            return object_of(
                *reinterpret_cast<const Value*>(static_cast<const char*>(config) + offset));
          }};
}

template Row row_of<bool>(const std::string&, std::ptrdiff_t);
template Row row_of<int>(const std::string&, std::ptrdiff_t);
template Row row_of<double>(const std::string&, std::ptrdiff_t);
template Row row_of<std::uint64_t>(const std::string&, std::ptrdiff_t);
template Row row_of<std::int64_t>(const std::string&, std::ptrdiff_t);
template Row row_of<std::chrono::microseconds>(const std::string&, std::ptrdiff_t);
template Row row_of<std::chrono::nanoseconds>(const std::string&, std::ptrdiff_t);
template Row row_of<std::optional<bool>>(const std::string&, std::ptrdiff_t);
template Row row_of<std::optional<double>>(const std::string&, std::ptrdiff_t);
template Row row_of<std::optional<std::chrono::nanoseconds>>(const std::string&, std::ptrdiff_t);
template Row row_of<Prefer>(const std::string&, std::ptrdiff_t);

void configure(void* config, const std::string& owner, const Table& keywords,
               const py::args& values, const py::kwargs& given) {
  std::vector<std::string> names;
  for (const Row& row : keywords.rows) names.push_back(row.name);
  const py::dict all = by_name(owner, names, keywords.by_position, values, given);
  for (const Row& row : keywords.rows) {
    if (all.contains(row.name)) row.set(config, all[row.name.c_str()]);
  }
}

py::dict told(const Table& keywords, const void* config, std::size_t from) {
  py::dict all;
  for (std::size_t i = from; i < keywords.rows.size(); ++i) {
    all[keywords.rows[i].name.c_str()] = keywords.rows[i].get(config);
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

void def_constructor(const py::object& type, const std::string& signature, Make make) {
  py::options options;
  options.disable_function_signatures();
  const auto init = [make = std::move(make)](py::detail::value_and_holder& place,
                                             const py::args& values, const py::kwargs& given) {
    place.value_ptr() = make(values, given);
  };
  def_method(type, "__init__", init, py::detail::is_new_style_constructor(), signature.c_str());
}

void def_arguments(const py::object& type, Open open, const void* (*config)(const void*),
                   const Table& keywords, const void* defaults_config) {
  const py::dict defaults = told(keywords, defaults_config);
  def_property(type, "parameters", py::cpp_function([=](const py::object& self) {
                 const auto inside = open(self);
                 const CallersTurn turn(inside->turns);
                 return told(keywords, config(inside->object.get()), keywords.by_position);
               }),
               "dict of the constructor's keyword parameters.");
  for (std::size_t i = 0; i < keywords.by_position; ++i) {  // width and height
    def_property(
        type, keywords.rows[i].name.c_str(),
        py::cpp_function([config, open, get = keywords.rows[i].get](const py::object& self) {
          return get(config(open(self)->object.get()));
        }),
        "px");
  }
  def_method(type, "__repr__", [=](const py::object& self) {
    const py::dict all = told(keywords, config(open(self)->object.get()));
    return repr_of(self, all, defaults, keywords.by_position);
  });
  def_method(type, "__reduce__", [=](const py::object& self) {
    const auto inside = open(self);
    const CallersTurn turn(inside->turns);
    if (inside->has_worked) {
      throw py::type_error("cannot pickle " +
                           py::cast<std::string>(py::type::of(self).attr("__name__")) +
                           ": it has worked, and what events have left in it stays in it; "
                           "pickle "
                           "its results, or a new one");
    }
    return reduced(self, type, told(keywords, config(inside->object.get())));
  });
}

}  // namespace asap::python
