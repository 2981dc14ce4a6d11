#include "ros/bridge/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "asap/core/result.hpp"
#include "ros/bridge/facts.hpp"

namespace asap::ros {
namespace {

constexpr std::size_t kShortest = 5;  // letters of a name whose misspelling is told

// Letters that are missing, too many or others (Levenshtein's distance).
std::size_t slips(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : from) {
    std::size_t before = row[0]++;  // of the row before, one to the left
    for (std::size_t i = 0; i < to.size(); ++i) {
      const std::size_t changed = before + static_cast<std::size_t>(letter != to[i]);
      before = row[i + 1];
      row[i + 1] = std::min({changed, before + 1, row[i] + 1});
    }
  }
  return row.back();
}

}  // namespace

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

bool is_foreign(std::string_view name, const std::string& text) {
  std::vector<std::string_view> ours;
  for (const NumberField& field : kNumbers) ours.emplace_back(field.name);
  for (const ChoiceField& field : kChoices) ours.emplace_back(field.name);
  if (std::ranges::find(ours, name) != ours.end()) return false;
  for (const std::string_view known : ours) {
    // A slip of a short name is another word: seed, speed.
    if (known.size() < kShortest || slips(name, known) > (known.size() - 1) / 3) continue;
    throw BadValue(name, text, {},
                   "the node has no such parameter; did you mean " + std::string(known) + "?");
  }
  return true;
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
