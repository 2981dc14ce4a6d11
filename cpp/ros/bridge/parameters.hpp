// Parameters: those of the nodes, with range and description, for every middleware the same. Every
// node has kLatency and kPrefer; a node that publishes packages has them all. A check names field,
// value and remedy.
//
// Any thread.
#pragma once

#include <array>
#include <span>
#include <string>

namespace asap::ros {

struct Parameters {
  double latency_ms = 10.0;
  double feedback_timeout_ms = 1000.0;
  double rate_bound = 0.0;
  std::string prefer = "balanced";
  std::string feedback = "none";
  std::string encoding = "evt3";
};

// They may change while the node runs.
struct NumberField {
  const char* name;
  double Parameters::* field;
  double least;
  double most;
  const char* description;
};

inline constexpr NumberField kLatency{
    "latency_ms", &Parameters::latency_ms, 0.1, 10'000.0,
    "Latency bound in ms, from the arrival of an event to the end of its processing."};
inline constexpr std::array kNumbers{
    kLatency,
    NumberField{"feedback_timeout_ms", &Parameters::feedback_timeout_ms, 1.0, 60'000.0,
                "Time in ms to wait for feedback before the next package; at least latency_ms."},
    NumberField{"rate_bound", &Parameters::rate_bound, 0.0, 1e9,
                "Most events per second to publish, more are thinned; 0: no bound."},
};

// They are chosen when the node starts.
struct ChoiceField {
  const char* name;
  std::string Parameters::* field;
  std::span<const char* const> choices;
  const char* description;
};

inline constexpr const char* kPreferences[] = {"balanced", "events", "continuity"};
inline constexpr const char* kFeedbacks[] = {"none", "topic", "service"};
inline constexpr const char* kOutputs[] = {"evt3", "mono", "dvs_msgs"};
inline constexpr ChoiceField kPrefer{
    "prefer", &Parameters::prefer, kPreferences,
    "What matters in overload: events, as many as possible; continuity, no gap; or balanced."};
inline constexpr std::array kChoices{
    kPrefer,
    ChoiceField{"feedback", &Parameters::feedback, kFeedbacks,
                "How the consumer says that it has finished a package: none, topic or service."},
    ChoiceField{"encoding", &Parameters::encoding, kOutputs,
                "Encoding of the packages: evt3, mono or, as dvs_msgs/EventArray, dvs_msgs."},
};

// Throws std::invalid_argument("<field> = <value>: <remedy>").
void check(const Parameters& parameters);

}  // namespace asap::ros
