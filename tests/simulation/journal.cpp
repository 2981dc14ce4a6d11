#include "journal.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>

namespace asap::simulation {

const char* name(Law law) noexcept {
  switch (law) {
    case Law::ledger:
      return "1 ledger";
    case Law::order:
      return "2 order";
    case Law::size:
      return "3 size";
    case Law::gamma:
      return "4 gamma";
    case Law::identity:
      return "5 identity";
    case Law::pending:
      return "6 pending";
    case Law::age:
      return "7 age";
    case Law::kept_set:
      return "8 kept set";
    case Law::liveness:
      return "9 liveness";
    case Law::protocol:
      return "protocol";
  }
  return "";
}

void Journal::fail(Law law, const char* what, double got, double wanted) noexcept {
  if (over()) return;
  failed_ = true;
  law_ = law;
  what_ = what;
  got_ = got;
  wanted_ = wanted;
}

std::string Journal::violation() const {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), "%s: %s: %.17g, wanted %.17g, at step %" PRIu64,
                name(law_), what_, got_, wanted_, steps_);
  return text.data();
}

std::string Journal::last_steps() const {
  std::string all;
  std::array<char, 160> text{};
  for (std::uint64_t i = steps_ - std::min<std::uint64_t>(steps_, lines_.size()); i < steps_; ++i) {
    const Line& line = lines_[i % lines_.size()];
    std::snprintf(text.data(), text.size(),
                  "  %8" PRIu64 "  %16" PRId64 " ns  %-12s %" PRIu64 " %" PRIu64 "\n", i + 1,
                  line.time_ns, line.what, line.a, line.b);
    all += text.data();
  }
  return all;
}

}  // namespace asap::simulation
