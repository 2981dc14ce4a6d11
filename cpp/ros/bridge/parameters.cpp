#include "ros/bridge/parameters.hpp"

#include <algorithm>
#include <cmath>

#include "asap/core/result.hpp"
#include "ros/bridge/facts.hpp"

namespace asap::ros {

std::string constraint(const NumberField& number) {
  return (number.is_whole ? "a whole number between " : "between ") + to_text(number.min) +
         " and " + to_text(number.max);
}

std::string constraint(const ChoiceField& choice) {
  std::string names;
  for (const char* name : choice.choices) names += (names.empty() ? "" : ", ") + std::string(name);
  return "one of " + names;
}

void set(Parameters& parameters, std::string_view name, const std::string& text,
         std::optional<double> number) {
  for (const ChoiceField& choice : kChoices) {
    if (name == choice.name) parameters.*choice.field = text;
  }
  for (const NumberField& field : kNumbers) {
    if (name != field.name) continue;
    if (!number) throw BadValue(name, text, {}, "must be a number");
    parameters.*field.field = *number;
  }
}

bool is_known(std::string_view name) {
  const auto is_it = [&](const auto& field) { return name == field.name && !is_of_dds(field.has); };
  return std::ranges::any_of(kNumbers, is_it) || std::ranges::any_of(kChoices, is_it);
}

void refuse_unknown(std::string_view name, const std::string& text) {
  throw BadValue(name, text, {},
                 "the node has no such parameter; correct the name, or leave it out");
}

void check(const Parameters& parameters) {
  for (const NumberField& number : kNumbers) {
    const double value = parameters.*number.field;
    const bool is_in_range = value >= number.min && value <= number.max;  // no NaN
    if (is_in_range && (!number.is_whole || value == std::floor(value))) continue;
    throw BadValue(number.name, to_text(value), {}, "must be " + constraint(number));
  }
  const double timeout_ms = parameters.feedback_timeout_ms;
  if (parameters.feedback != "none" && timeout_ms < parameters.latency_ms) {
    throw BadValue("feedback_timeout_ms", to_text(timeout_ms), {},
                   "must be at least latency_ms = " + to_text(parameters.latency_ms));
  }
  for (const ChoiceField& choice : kChoices) {
    const std::string_view value = parameters.*choice.field;
    if (std::ranges::find(choice.choices, value) != choice.choices.end()) continue;
    throw BadValue(choice.name, value, {}, "must be " + constraint(choice));
  }
}

}  // namespace asap::ros
