#include "ros/bridge/parameters.hpp"

#include <algorithm>
#include <string_view>

#include "asap/core/check.hpp"

namespace asap::ros {

void check(const Parameters& parameters) {
  for (const NumberField& number : kNumbers) {
    const double value = parameters.*number.field;
    require(value >= number.least && value <= number.most, number.name, value,
            "must be between " + to_text(number.least) + " and " + to_text(number.most));
  }
  require(parameters.feedback == "none" || parameters.feedback_timeout_ms >= parameters.latency_ms,
          "feedback_timeout_ms", parameters.feedback_timeout_ms,
          "must be at least latency_ms = " + to_text(parameters.latency_ms));
  for (const ChoiceField& choice : kChoices) {
    const std::string& value = parameters.*choice.field;
    if (std::ranges::find(choice.choices, std::string_view(value)) != choice.choices.end()) {
      continue;
    }
    std::string names;
    for (const char* name : choice.choices)
      names += (names.empty() ? "" : ", ") + std::string(name);
    throw_bad_value(choice.name, value, "must be one of " + names);
  }
}

}  // namespace asap::ros
