// Schemes alone: a configuration is refused by name, or takes a thousand decisions about any
// backlog and any outcome without NaN, infinity or more events than there are. R24.
#include <cmath>
#include <stdexcept>
#include <string>

#include "any_scheme.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

constexpr std::int64_t kEndOfTimeNs = 9'200'000'000'000'000'000;
constexpr std::size_t kMaxWaiting = std::size_t{1} << 16;

// Events spread evenly from the oldest to now.
class EvenBacklog final : public BacklogCounts {
 public:
  EvenBacklog(std::size_t count, std::int64_t oldest_ns, std::int64_t now_ns)
      : count_(count), oldest_ns_(oldest_ns), now_ns_(now_ns) {}

  std::size_t before(std::int64_t time_ns) const noexcept override {
    if (time_ns <= oldest_ns_) return 0;
    if (time_ns > now_ns_) return count_;
    const double share =
        static_cast<double>(time_ns - oldest_ns_) / static_cast<double>(now_ns_ - oldest_ns_);
    return std::min(count_, 1 + static_cast<std::size_t>(share * static_cast<double>(count_)));
  }
  std::size_t about_before(std::int64_t time_ns) const noexcept override { return before(time_ns); }

 private:
  std::size_t count_;
  std::int64_t oldest_ns_;
  std::int64_t now_ns_;
};

// The moments of a run: time goes on, and nobody knows by how much.
struct Run {
  explicit Run(fuzz::Bytes& from) : bytes(from) {}

  std::int64_t step_ns() {
    const auto kind = bytes.take<std::uint8_t>();
    const std::int64_t left_ns = kEndOfTimeNs - now_ns;
    if (kind < 4)
      return std::min(static_cast<std::int64_t>(bytes.take<std::uint64_t>() >> (1 + kind)),
                      left_ns);
    return std::min<std::int64_t>(std::int64_t{bytes.take<std::uint16_t>()} << (kind % 24),
                                  left_ns);
  }

  void decide(Scheme& scheme) {
    now_ns += step_ns();
    oldest_ns = std::clamp<std::int64_t>(now_ns - step_ns(), oldest_ns, now_ns);
    const std::size_t count = 1 + bytes.count(kMaxWaiting) % kMaxWaiting;
    const bool due = bytes.flag();
    const EvenBacklog counts(count, oldest_ns, now_ns);
    const Decision decision = scheme.decide({.count = count,
                                             .now_ns = now_ns,
                                             .oldest_ns = oldest_ns,
                                             .previous_start_ns = previous_ns,
                                             .due = due,
                                             .counts = counts});
    if (!decision.takes) return;
    fuzz::check(decision.stale <= count && decision.raw <= count - decision.stale);
    fuzz::check(decision.stale + decision.raw >= 1);
    fuzz::check(decision.gamma >= 0.0 && decision.gamma <= 1.0);
    fuzz::check(decision.budget_ns >= 1);
    fuzz::check(std::isfinite(decision.fixed_ns) && decision.fixed_ns >= 0.0);
    fuzz::check(std::isfinite(decision.event_ns) && decision.event_ns >= 0.0);
    if (decision.raw > 0) complete(scheme, decision);
  }

  void complete(Scheme& scheme, const Decision& decision) {
    const double share = bytes.flag() ? decision.gamma : bytes.take<std::uint8_t>() / 255.0;
    const auto kept = static_cast<std::size_t>(share * static_cast<double>(decision.raw));
    const std::int64_t start_ns = now_ns;
    previous_ns = now_ns;
    now_ns += step_ns();
    scheme.observe({.size = std::min(kept, decision.raw),
                    .raw = decision.raw,
                    .span_ns = step_ns(),
                    .start_ns = start_ns,
                    .processing_ns = now_ns - start_ns});
  }

  fuzz::Bytes& bytes;
  std::int64_t now_ns = 0;
  std::int64_t oldest_ns = 0;
  std::int64_t previous_ns = kLongAgo;
};

void check_cost(const LinearCost& cost, fuzz::Bytes& bytes) {
  for (std::uint64_t package = 0; package < 4; ++package) {
    const auto now_ns = static_cast<std::int64_t>(bytes.take<std::uint64_t>() >> 1);
    if (now_ns > kEndOfTimeNs) continue;
    const std::int64_t start_ns = cost.start_ns(now_ns);
    fuzz::check(start_ns >= now_ns);
    const PackageCost of = cost.package(package, start_ns);
    fuzz::check(of.fixed_ns >= 0 && of.event_ns >= 0 && std::isfinite(of.of(1 << 20)));
    fuzz::check(cost.done_ns(start_ns, of.of(bytes.count(1 << 20))) >= start_ns);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  try {
    if (bytes.below(8) == 0) {
      check_cost(fuzz::any_cost(bytes), bytes);
      return 0;
    }
    const auto scheme = fuzz::any_scheme(bytes);
    for (const auto& [name, value] : scheme->parameters()) {
      const auto* real = std::get_if<double>(&value);
      fuzz::check(!name.empty() && (real == nullptr || std::isfinite(*real)));
    }
    scheme->reset(bytes.flag() ? Execution::whole : Execution::anytime);
    Run run(bytes);
    for (int i = 0; i < 1000 && !bytes.empty(); ++i) run.decide(*scheme);
  } catch (const std::invalid_argument& refused) {
    fuzz::check(std::string(refused.what()).find(" = ") != std::string::npos);
  }
  return 0;
}
