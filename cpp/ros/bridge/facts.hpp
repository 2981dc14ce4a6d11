// Facts: what a node reports, by name; "ledger.received" is the entry of a JSON object "ledger".
// The keys are those of Python's Pipeline.stats().
//
// Any thread. Allocates.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "asap/runner/pipeline.hpp"

namespace asap::ros {

// Name and value; the value is a number or a quoted text of JSON.
using Facts = std::vector<std::pair<std::string, std::string>>;

std::string number(double value);
std::string number(std::uint64_t value);
std::string quoted(std::string_view text);

Facts facts_of(const PipelineStats& stats);

// One object on one line. Entries of one object stand side by side in `facts`.
std::string to_json(const Facts& facts);

// "received 10 = delivered 7 + discarded 3", the counts that are not 0.
std::string sentence(const Ledger& ledger);

}  // namespace asap::ros
