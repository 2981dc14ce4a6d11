// A scheme as a class of Python, made from its configuration's kParameters: the keywords of the
// constructor with their defaults, .parameters, and what inspect.signature shows.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "arguments.hpp"
#include "asap/schemes/bounded_scheme.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap::python {

// CPython takes arguments that open a docstring off it and shows them as the signature.
inline std::string with_arguments(const char* name, const std::string& arguments, const char* doc) {
  return name + ("(" + arguments + ")\n--\n\n") + doc;
}

// The class and its constructor; `arguments` as Python writes them.
template <class S, class... Constructor>
pybind11::class_<S, Scheme> scheme_class(pybind11::module_& m, const char* name, const char* doc,
                                         const std::string& arguments,
                                         Constructor&&... constructor) {
  pybind11::class_<S, Scheme> bound(m, name, with_arguments(name, arguments, doc).c_str());
  bound.def(std::forward<Constructor>(constructor)...);
  const auto init = pybind11::detail::get_function(bound.attr("__init__"));
  auto* record =
      pybind11::detail::function_record_ptr_from_PyObject(PyCFunction_GET_SELF(init.ptr()));
  const char*& text = record->def->ml_doc;
  const std::string self = arguments.empty() ? "self" : "self, ";
  char* signed_text =
      PYBIND11_COMPAT_STRDUP(with_arguments("__init__", self + arguments, text).c_str());
  std::free(const_cast<char*>(text));  // as pybind11 will, with the new one
  text = signed_text;
  return bound;
}

// The values by name, as far as the scheme tells them.
inline pybind11::dict scheme_parameters(const Scheme& scheme) {
  pybind11::dict result;
  for (const auto& [name, value] : scheme.parameters()) {
    result[pybind11::str(name)] = pybind11::cast(value);
  }
  return result;
}

// A whole number comes as it is, to be refused by its name.
template <class Value>
using ArgumentOf =
    std::conditional_t<std::is_same_v<Value, std::size_t>, const pybind11::object&, Value>;

inline std::size_t value_of(const char* name, const pybind11::object& given) {
  return whole_number(name, given);
}
template <class Value>
Value value_of(const char*, Value given) {
  return given;
}

template <class S, class Config, class... Values>
pybind11::class_<S, Scheme> keyword_class(pybind11::module_& m, const char* name, const char* doc,
                                          const NamedField<Config, Values>&... fields) {
  const Config defaults;
  std::string arguments = "*";
  const auto add = [&arguments](const char* field, const auto& value) {
    const auto written = pybind11::repr(pybind11::cast(value));
    arguments.append(", ").append(field).append("=").append(pybind11::cast<std::string>(written));
  };
  (add(fields.name, defaults.*fields.field), ...);
  return scheme_class<S>(
      m, name, doc, arguments, pybind11::init([fields...](ArgumentOf<Values>... given) {
        Config config;
        ((config.*fields.field = value_of(fields.name, given)), ...);
        return S(config);
      }),
      pybind11::kw_only(), (pybind11::arg(fields.name) = defaults.*fields.field)...);
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
  if constexpr (requires { S::Config::kParameters; }) {
    std::apply(
        [&]<class Config, class... Values>(const NamedField<Config, Values>&... fields) {
          auto bound = keyword_class<S>(m, name, doc, fields...);
          if constexpr ((std::is_same_v<Values, std::optional<double>> || ...)) {
            bind_all_parameters(bound, fields...);
          }
          if constexpr (std::is_base_of_v<BoundedScheme, S>) bind_cost(bound);
        },
        S::Config::kParameters);
  } else {
    scheme_class<S>(m, name, doc, "", pybind11::init<>());
  }
}

}  // namespace asap::python
