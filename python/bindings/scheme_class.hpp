// A scheme as a class of Python, made from its configuration's kParameters: the keywords of the
// constructor with their defaults, and .parameters.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "arguments.hpp"
#include "asap/schemes/bounded_scheme.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/scheme.hpp"
#include "pickles.hpp"

namespace asap::python {

// The values by name, as far as the scheme tells them.
inline pybind11::dict scheme_parameters(const Scheme& scheme) {
  pybind11::dict result;
  for (const auto& [name, value] : scheme.parameters()) {
    result[pybind11::str(name)] = pybind11::cast(value);
  }
  return result;
}

// A whole number comes as it is, to be refused by its name; a choice as the name of what is chosen.
template <class Value>
using ArgumentOf =
    std::conditional_t<std::is_same_v<Value, std::size_t>, const pybind11::object&,
                       std::conditional_t<std::is_enum_v<Value>, std::string, Value>>;

inline std::size_t value_of(const char* name, const pybind11::object& given) {
  return whole_number(name, given);
}
inline Prefer value_of(const char*, const std::string& given) { return prefer_of(given); }
template <class Value>
Value value_of(const char*, Value given) {
  return given;
}

inline auto default_of(const auto& value) {
  if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>) {
    return std::string(name_of(value));
  } else {
    return value;
  }
}

template <class S, class Config, class... Values>
pybind11::class_<S, Scheme> keyword_class(pybind11::module_& m, const char* name, const char* doc,
                                          const NamedField<Config, Values>&... fields) {
  const Config defaults;
  pybind11::class_<S, Scheme> bound(m, name, doc);
  bound.def(pybind11::init([fields...](ArgumentOf<Values>... given) {
              Config config;
              ((config.*fields.field = value_of(fields.name, given)), ...);
              return S(config);
            }),
            pybind11::kw_only(),
            (pybind11::arg(fields.name) = default_of(defaults.*fields.field))...);
  return bound;
}

// .parameters of a scheme that leaves some out: those are None.
template <class S, class Config, class... Values>
void bind_all_parameters(pybind11::class_<S, Scheme>& bound,
                         const NamedField<Config, Values>&... fields) {
  bound.def_property_readonly(
      "parameters",
      [fields...](const S& scheme) {
        pybind11::dict result;
        ((result[fields.name] = pybind11::none()), ...);
        result.attr("update")(scheme_parameters(scheme));
        return result;
      },
      "The constructor's arguments by name.");
}

template <class S>
void bind_cost(pybind11::class_<S, Scheme>& bound) {
  bound
      .def_property_readonly(
          "alpha_us", [](const S& scheme) { return scheme.alpha_ns() * 1e-3; },
          "Fixed cost of a package at present, as measured, us.")
      .def_property_readonly("beta_ns", &S::beta_ns,
                             "Cost of an event at present, as measured, ns.");
}

template <class S>
void bind_scheme(pybind11::module_& m, const char* name, const char* doc) {
  const auto reduce = [](const pybind11::object& self) {
    return by_arguments(self, pybind11::type::of<S>());
  };
  if constexpr (requires { S::Config::kParameters; }) {
    std::apply(
        [&]<class Config, class... Values>(const NamedField<Config, Values>&... fields) {
          auto bound = keyword_class<S>(m, name, doc, fields...);
          bound.def("__reduce__", reduce);
          if constexpr ((std::is_same_v<Values, std::optional<double>> || ...)) {
            bind_all_parameters(bound, fields...);
          }
          if constexpr (std::is_base_of_v<BoundedScheme, S>) bind_cost(bound);
        },
        S::Config::kParameters);
  } else {
    pybind11::class_<S, Scheme>(m, name, doc).def(pybind11::init<>()).def("__reduce__", reduce);
  }
}

}  // namespace asap::python
