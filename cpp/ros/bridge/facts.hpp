// Facts: what a node reports, by name; "ledger.received" is the entry of a JSON object "ledger".
// The keys are those of Python's Pipeline.stats().
//
// Any thread. Allocates.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "asap/runner/pipeline.hpp"

namespace asap::ros {

struct Fact {
  std::string name;
  std::string value;
  bool is_text = false;  // else a number, true, false or null

  friend bool operator==(const Fact&, const Fact&) = default;
};
using Facts = std::vector<Fact>;

std::string to_text(double value);  // 12 digits at most
std::string number(double value);   // the same; "null" if it is not finite
std::string number(std::uint64_t value);
Fact text(std::string name, std::string_view value);

Facts facts_of(const PipelineStats& stats);

// One object on one line. Entries of one object stand side by side in `facts`.
std::string to_json(const Facts& facts);

// "received 10 = delivered 7 + discarded 3", the counts that are not 0.
std::string sentence(const Ledger& ledger);

}  // namespace asap::ros
