// Parameters: those of the nodes, with range and description, for every middleware the same. A
// check names field, value and remedy.
//
// Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace asap::ros {

struct Parameters {
  double latency_ms = 10.0;
  double feedback_timeout_ms = 1000.0;
  double rate_bound = 0.0;
  double reorder_tolerance_us = 0.0;
  double warmup_discard_us = 0.0;
  double capacity = 0.0;
  double seed = 0.0;
  double queue = 1000.0;
  std::string prefer = "balanced";
  std::string when_full = "thin";
  std::string feedback = "topic";
  std::string encoding = "evt3";
  std::string input = "event_camera_msgs";
  std::string input_reliability = "best_effort";
  std::string output_reliability = "reliable";
};

// Which nodes have a parameter.
enum class Has : std::uint8_t { every_node, packages, dds, dds_packages };
constexpr bool is_of_packages(Has has) { return has == Has::packages || has == Has::dds_packages; }
constexpr bool is_of_dds(Has has) { return has >= Has::dds; }

struct NumberField {
  const char* name;
  double Parameters::* field;
  double min;
  double max;
  bool is_whole;
  bool is_fixed;  // when the node starts
  Has has;
  const char* description;
};

inline constexpr std::array kNumbers{
    NumberField{"latency_ms", &Parameters::latency_ms, 0.1, 10'000.0, false, false, Has::every_node,
                "Latency bound in ms, from the arrival of an event to the end of its processing."},
    NumberField{"reorder_tolerance_us", &Parameters::reorder_tolerance_us, 0.0, 999'999.0, true,
                true, Has::every_node, "Events late by at most this time in us are not rejected."},
    NumberField{"warmup_discard_us", &Parameters::warmup_discard_us, 0.0, 1e9, true, true,
                Has::every_node, "Events within this time in us after the first are dropped."},
    NumberField{"capacity", &Parameters::capacity, 0.0, 1e9, true, true, Has::every_node,
                "Events that wait in the ring; 0: as the latency bound needs."},
    NumberField{"seed", &Parameters::seed, 0.0, 1e15, true, true, Has::every_node,
                "Seed of the choice of events where they are thinned."},
    NumberField{"queue", &Parameters::queue, 1.0, 100'000.0, true, true, Has::every_node,
                "Messages that wait in the middleware, on either side."},
    NumberField{"feedback_timeout_ms", &Parameters::feedback_timeout_ms, 1.0, 60'000.0, false,
                false, Has::packages,
                "Time in ms to wait for feedback before the next package; at least latency_ms."},
    NumberField{"rate_bound", &Parameters::rate_bound, 0.0, 1e9, false, false, Has::packages,
                "Most events per second to publish, more are thinned; 0: no bound."},
};

// They are chosen when the node starts.
struct ChoiceField {
  const char* name;
  std::string Parameters::* field;
  std::span<const char* const> choices;
  Has has;
  const char* description;
};

inline constexpr const char* kPreferences[] = {"balanced", "events", "continuity"};
inline constexpr const char* kWhenFull[] = {"thin", "keep_oldest", "keep_newest"};
inline constexpr const char* kFeedbacks[] = {"topic", "service", "none"};
inline constexpr const char* kOutputs[] = {"evt3", "mono", "dvs_msgs"};
inline constexpr const char* kInputs[] = {"event_camera_msgs", "dvs_msgs"};
inline constexpr const char* kReliabilities[] = {"best_effort", "reliable"};
inline constexpr std::array kChoices{
    ChoiceField{"prefer", &Parameters::prefer, kPreferences, Has::every_node,
                "What matters in overload: events, as many as possible; continuity, short gaps."},
    ChoiceField{"when_full", &Parameters::when_full, kWhenFull, Has::every_node,
                "What gives way when the ring is full."},
    ChoiceField{"feedback", &Parameters::feedback, kFeedbacks, Has::packages,
                "How the consumer says that it has finished a package."},
    ChoiceField{"encoding", &Parameters::encoding, kOutputs, Has::packages,
                "Encoding of the packages; dvs_msgs: they are of dvs_msgs/EventArray."},
    ChoiceField{"input", &Parameters::input, kInputs, Has::dds,
                "Package of the messages on `events`."},
    ChoiceField{"input_reliability", &Parameters::input_reliability, kReliabilities, Has::dds,
                "QoS of `events`; best_effort hears every publisher."},
    ChoiceField{"output_reliability", &Parameters::output_reliability, kReliabilities,
                Has::dds_packages, "QoS of the packages; every subscriber hears reliable."},
};

// "between 0.1 and 10000", "a whole number between 1 and 9", "one of a, b".
std::string constraint(const NumberField& number);
std::string constraint(const ChoiceField& choice);

// Sets the field of this name, if there is one: a choice to the text, a number to the number.
// Throws std::invalid_argument where it is none.
void set(Parameters& parameters, std::string_view name, const std::string& text,
         std::optional<double> number);

// Whether a parameter is not of these nodes, as those of a file for all nodes. Throws
// std::invalid_argument for a misspelt one of theirs.
bool is_foreign(std::string_view name, const std::string& text);

// Throws std::invalid_argument("<field> = <value>: <remedy>").
void check(const Parameters& parameters);

}  // namespace asap::ros
