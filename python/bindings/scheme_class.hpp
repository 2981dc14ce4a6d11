// A scheme as a class of Python, made from its configuration's kParameters: the keywords of the
// constructor with their defaults, and .parameters.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <tuple>

#include "asap/schemes/scheme.hpp"
#include "held.hpp"
#include "keywords.hpp"
#include "per_event.hpp"

namespace asap::python {

// The values by name, as far as the scheme tells them.
inline pybind11::dict scheme_parameters(const Scheme& scheme) {
  pybind11::dict result;
  for (const auto& [name, value] : scheme.parameters()) {
    result[pybind11::str(name)] = pybind11::cast(value);
  }
  return result;
}

template <class S>
void bind_cost(Class<S, Scheme>& bound) {
  bound
      .def_property_readonly(
          "alpha_us", [](const S& scheme) { return scheme.alpha_ns() * 1e-3; },
          "Fixed cost of a package at present, as measured, us.")
      .def_property_readonly("beta_ns", &S::beta_ns,
                             "Cost of an event at present, as measured, ns.");
}

template <class S>
auto keywords_of_scheme() {
  if constexpr (requires { S::Config::kParameters; }) {
    return std::apply(
        [](const auto&... fields) {
          return Keywords<typename S::Config>(0, {keyword(fields.name, fields.field)...});
        },
        S::Config::kParameters);
  } else {
    struct None {};
    return Keywords<None>(0, {});
  }
}

template <class S>
void bind_scheme(pybind11::module_& m, const char* name, const char* doc) {
  Class<S, Scheme> bound(m, name, documented(doc).c_str());
  const auto keywords = keywords_of_scheme<S>();
  bind_constructor(bound, keywords);
  // A scheme leaves out what it has no value of.
  const auto parameters = [keywords](const S& scheme) {
    pybind11::dict all;
    for (const auto& row : keywords.rows) all[row.name.c_str()] = pybind11::none();
    all.attr("update")(scheme_parameters(scheme));
    return all;
  };
  bound.def_property_readonly("parameters", parameters, "The constructor's arguments by name.")
      .def("__reduce__", [](const pybind11::object& self) {
        return reduced(self, pybind11::type::of<S>(), self.attr("parameters"));
      });
  if constexpr (requires(const S& scheme) { scheme.alpha_ns(); }) bind_cost(bound);
}

}  // namespace asap::python
