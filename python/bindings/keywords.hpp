// A class of Python that is made from a configuration. A table lists the constructor's arguments:
// from it come the constructor, inspect.signature, .parameters, the repr and the pickle.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/scheme.hpp"
#include "held.hpp"

namespace asap::python {

template <class Config>
struct Keyword {
  std::string name;
  std::function<void(Config&, pybind11::handle)> set;
  std::function<pybind11::object(const Config&)> get;
};

// The arguments of a constructor in order; the first ones may be given by position and are
// required.
template <class Config>
struct Keywords {
  std::size_t by_position = 0;
  std::vector<Keyword<Config>> rows = {};
};

// The names of a choice, in the order of a message.
template <class Kind, std::size_t count>
using Choices = std::array<std::pair<const char*, Kind>, count>;

// ---- one value ----

// Nanoseconds are a number of ms in Python, another duration is a number of its own unit.
template <class Value>
concept Duration = requires { typename Value::period; };

template <class Value>
Value value_of(const char* name, pybind11::handle given) {
  namespace py = pybind11;
  if constexpr (std::is_same_v<Value, std::optional<bool>>) {
    if (given.is_none()) return std::nullopt;
    try {
      return given.cast<bool>();
    } catch (const py::cast_error&) {
      throw_wrong_kind(name, given, "give True, False or None");
    }
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
pybind11::object object_of(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return pybind11::cast(name_of(value));
  } else if constexpr (std::is_same_v<Value, std::chrono::nanoseconds>) {
    return pybind11::cast(ms_of(value));
  } else if constexpr (Duration<Value>) {
    return pybind11::cast(value.count());
  } else {
    return pybind11::cast(value);
  }
}

template <class Kind, std::size_t count>
Kind chosen(const Choices<Kind, count>& choices, const char* name, pybind11::handle given) {
  std::string names;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [text, kind] = choices[i];
    if (pybind11::isinstance<pybind11::str>(given) && given.equal(pybind11::str(text))) return kind;
    names += i == 0 ? "must be " : i + 1 < count ? ", " : " or ";
    names.append("\"").append(text).append("\"");
  }
  throw_bad_value(name, shown(given), names);
}

template <class Kind, std::size_t count>
const char* name_in(const Choices<Kind, count>& choices, Kind kind) {
  for (const auto& [text, known] : choices) {
    if (known == kind) return text;
  }
  return "";
}

// ---- a row ----

template <class Config, class Value>
Keyword<Config> keyword(std::string name, Value Config::* field) {
  return {
      .name = name,
      .set = [=](Config& config,
                 pybind11::handle given) { config.*field = value_of<Value>(name.c_str(), given); },
      .get = [=](const Config& config) { return object_of(config.*field); }};
}

template <class Config, class Kind, std::size_t count>
Keyword<Config> keyword(std::string name, Kind Config::* field,
                        const Choices<Kind, count>& choices) {
  return {
      .name = name,
      .set = [=](Config& config,
                 pybind11::handle given) { config.*field = chosen(choices, name.c_str(), given); },
      .get = [=](const Config& config) { return pybind11::str(name_in(choices, config.*field)); }};
}

// Width and height, then what follows.
template <class Config>
Keywords<Config> sized(std::vector<Keyword<Config>> rows = {}) {
  rows.insert(rows.begin(), {keyword("width", &Config::width), keyword("height", &Config::height)});
  return {.by_position = 2, .rows = std::move(rows)};
}

// ---- all of them ----

// The values by name; TypeError for what is unknown, missing or given twice. `owner` is how the
// message calls the class.
pybind11::dict by_name(const std::string& owner, const std::vector<std::string>& names,
                       std::size_t by_position, const pybind11::args& values,
                       const pybind11::kwargs& given);

template <class Config>
Config config_of(const std::string& owner, const Keywords<Config>& keywords,
                 const pybind11::args& values, const pybind11::kwargs& given) {
  std::vector<std::string> names;
  for (const auto& row : keywords.rows) names.push_back(row.name);
  const pybind11::dict all = by_name(owner, names, keywords.by_position, values, given);
  Config config{};
  for (const auto& row : keywords.rows) {
    if (all.contains(row.name)) row.set(config, all[row.name.c_str()]);
  }
  return config;
}

// The arguments by name, from one on.
template <class Config>
pybind11::dict told(const Keywords<Config>& keywords, const Config& config, std::size_t from = 0) {
  pybind11::dict all;
  for (std::size_t i = from; i < keywords.rows.size(); ++i) {
    all[keywords.rows[i].name.c_str()] = keywords.rows[i].get(config);
  }
  return all;
}

// "__init__(self, width, height, *, window_us=5000)" as CPython reads it off a docstring.
std::string signature_of(const pybind11::dict& defaults, std::size_t by_position);

// "EFast(20, 10)": how to make an object anew, without what is a default.
std::string repr_of(const pybind11::handle& made, const pybind11::dict& arguments,
                    const pybind11::dict& defaults, std::size_t by_position);

// The value of __reduce__: the type and its arguments. TypeError for a class derived in Python,
// which may hold more than that.
pybind11::tuple reduced(const pybind11::handle& made, const pybind11::handle& type,
                        const pybind11::dict& arguments);

// The refusal to pickle what its arguments no longer tell.
[[noreturn]] void throw_has_worked(const pybind11::handle& made);

// A constructor that the table describes; `make` returns a new object. Its docstring is its
// signature alone.
template <class Bound, class Make>
void def_constructor(Bound& bound, const std::string& signature, Make make) {
  pybind11::options options;
  options.disable_function_signatures();
  bound.def(pybind11::init(make), signature.c_str());
}

template <class T, class... Bases, class Config>
void bind_constructor(Class<T, Bases...>& bound, const Keywords<Config>& keywords) {
  namespace py = pybind11;
  const auto owner = py::cast<std::string>(bound.attr("__name__"));
  def_constructor(bound, signature_of(told(keywords, Config{}), keywords.by_position),
                  [=](const py::args& values, const py::kwargs& given) {
                    const Config config = config_of(owner, keywords, values, given);
                    if constexpr (std::is_constructible_v<T, const Config&>) {
                      return new T(config);
                    } else {
                      return new T();
                    }
                  });
}

}  // namespace asap::python
