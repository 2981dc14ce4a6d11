// A class of Python that is made from a configuration. A table lists the constructor's arguments:
// from it come the constructor, inspect.signature, .parameters, the repr and the pickle.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "asap/schemes/scheme.hpp"
#include "held.hpp"

namespace asap::python {

// An argument of a constructor: how it is set in a configuration and read from it. Behind the
// pointer is the configuration, whatever its type.
struct Row {
  std::string name;
  std::function<void(void*, pybind11::handle)> set;
  std::function<pybind11::object(const void*)> get;
};

// The arguments of a constructor in order; the first ones may be given by position and are
// required.
struct Table {
  std::size_t by_position = 0;
  std::vector<Row> rows = {};
};

// The same of a Config.
template <class Config>
struct Keyword : Row {};

template <class Config>
struct Keywords : Table {
  Keywords(std::size_t by, std::initializer_list<Keyword<Config>> all) : Table{by, {}} {
    for (const Row& row : all) rows.push_back(row);
  }
};

// The names of a choice, in the order of a message.
template <class Kind, std::size_t count>
using Choices = std::array<std::pair<const char*, Kind>, count>;

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

inline constexpr Choices<Execution, 2> kExecutions{
    {{"anytime", Execution::anytime}, {"whole", Execution::whole}}};

// ---- a row ----

// Returns the row of the Value at an offset in a configuration. Nanoseconds are a number of ms in
// Python, another duration is a number of its own unit. A Value of another type: instantiate it in
// keywords.cpp.
template <class Value>
Row row_of(const std::string& name, std::ptrdiff_t offset);

template <class Config, class Value>
Keyword<Config> keyword(const std::string& name, Value Config::* field) {
  const Config config{};
  return {row_of<Value>(name, reinterpret_cast<const char*>(&(config.*field)) -
                                  reinterpret_cast<const char*>(&config))};
}

// Returns a keyword whose value `set` stores and `get` reads.
template <class Config, class Set, class Get>
Keyword<Config> keyword(const std::string& name, Set set, Get get) {
  return {{name,
           [=](void* config, pybind11::handle given) { set(*static_cast<Config*>(config), given); },
           [=](const void* config) -> pybind11::object {
             return get(*static_cast<const Config*>(config));
           }}};
}

template <class Config, class Kind, std::size_t count>
Keyword<Config> keyword(const std::string& name, Kind Config::* field,
                        const Choices<Kind, count>& choices) {
  return keyword<Config>(
      name,
      [=](Config& config, pybind11::handle given) {
        config.*field = chosen(choices, name.c_str(), given);
      },
      [=](const Config& config) { return pybind11::str(name_in(choices, config.*field)); });
}

// Width and height, then what follows.
template <class Config>
Keywords<Config> sized(std::initializer_list<Keyword<Config>> rows = {}) {
  Keywords<Config> all(2, {keyword("width", &Config::width), keyword("height", &Config::height)});
  for (const Row& row : rows) all.rows.push_back(row);
  return all;
}

// ---- all of them ----

// Sets what is given; TypeError for what is unknown, missing or given twice. `owner` is how the
// message calls the class.
void configure(void* config, const std::string& owner, const Table& keywords,
               const pybind11::args& values, const pybind11::kwargs& given);

// The arguments by name, from one on.
pybind11::dict told(const Table& keywords, const void* config, std::size_t from = 0);

// "__init__(self, width, height, *, window_us=5000)" as CPython reads it off a docstring.
std::string signature_of(const pybind11::dict& defaults, std::size_t by_position);

// The value of __reduce__: the type and its arguments. TypeError for a class derived in Python,
// which may hold more than that.
pybind11::tuple reduced(const pybind11::handle& made, const pybind11::handle& type,
                        const pybind11::dict& arguments);

// A constructor that the table describes; `make` returns a new object. Its docstring is its
// signature alone.
using Make = std::function<void*(const pybind11::args&, const pybind11::kwargs&)>;
void def_constructor(const pybind11::object& type, const std::string& signature, Make make);

// What the constructor's arguments tell of an object: .parameters, the repr, and the pickle of one
// that is new. `config` finds the configuration in an object.
void def_arguments(const pybind11::object& type, Open open, const void* (*config)(const void*),
                   const Table& keywords, const void* defaults);

template <class T, class... Bases, class Config>
void bind_constructor(Class<T, Bases...>& type, const Keywords<Config>& keywords) {
  const Config defaults{};
  const auto owner = pybind11::cast<std::string>(type.attr("__name__"));
  def_constructor(type, signature_of(told(keywords, &defaults), keywords.by_position),
                  [=](const pybind11::args& values, const pybind11::kwargs& given) -> void* {
                    Config config{};
                    configure(&config, owner, keywords, values, given);
                    if constexpr (std::is_constructible_v<T, const Config&>) {
                      return new T(config);
                    } else {
                      return new T();
                    }
                  });
}

// All that the table of the constructor's arguments gives to a class.
template <class T, class Config>
void bind_configuration(Class<T>& type, const Keywords<Config>& keywords) {
  const Config defaults{};
  bind_constructor(type, keywords);
  def_arguments(
      type, &inside_of<T>,
      [](const void* self) -> const void* { return &static_cast<const T*>(self)->config(); },
      keywords, &defaults);
}

}  // namespace asap::python
