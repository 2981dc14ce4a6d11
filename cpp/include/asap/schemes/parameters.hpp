// The parameters of a scheme by name. A configuration lists its fields once, in kParameters, in the
// order of the constructor's keywords:
//
//   static constexpr std::tuple kParameters{NamedField{"size", &FixedSizeConfig::size}};
//
// From that list come the values that a scheme tells and, in Python, the keywords, defaults and
// signature of its constructor, the stub and the command line. Any thread; parameters_of allocates.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace asap {

// The constructor's parameters by name. A choice is told by its name.
using SchemeParameter = std::variant<std::int64_t, double, std::string_view>;
using SchemeParameters = std::vector<std::pair<std::string_view, SchemeParameter>>;

template <class Config, class Value>
struct NamedField {
  const char* name;
  Value Config::* field;
};
template <class Config, class Value>
NamedField(const char*, Value Config::*) -> NamedField<Config, Value>;

// The values in the order of Config::kParameters. An optional one without a value is left out; a
// time is told in ms, as its name says.
template <class Config>
SchemeParameters parameters_of(const Config& config) {
  SchemeParameters parameters;
  const auto add = [&parameters](const char* name, const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::optional<double>>) {
      if (value) parameters.emplace_back(name, *value);
    } else if constexpr (std::is_same_v<Value, std::size_t>) {
      parameters.emplace_back(name, static_cast<std::int64_t>(value));
    } else if constexpr (std::is_same_v<Value, std::chrono::nanoseconds>) {
      parameters.emplace_back(name, static_cast<double>(value.count()) / 1e6);
    } else if constexpr (std::is_enum_v<Value>) {
      parameters.emplace_back(name, name_of(value));
    } else {
      parameters.emplace_back(name, value);
    }
  };
  std::apply([&](const auto&... rows) { (add(rows.name, config.*rows.field), ...); },
             Config::kParameters);
  return parameters;
}

}  // namespace asap
