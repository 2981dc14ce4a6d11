// Validator: any 16-byte events under any configuration. What passes is ordered, in frame and
// counted, and how the events are cut makes no difference.
#include <stdexcept>
#include <string>
#include <vector>

#include "asap/filter/validator.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

ValidatorConfig config_of(fuzz::Bytes& bytes) {
  const auto size = [&]() -> int {
    return bytes.flag() ? bytes.take<std::int32_t>() : static_cast<int>(bytes.below(400));
  };
  const int width = size();
  const int height = size();
  return {.width = width,
          .height = height,
          .on_bad = static_cast<OnBad>(bytes.below(3)),
          .reorder_tolerance = bytes.flag() ? std::chrono::nanoseconds(bytes.take<std::int64_t>())
                                            : std::chrono::microseconds(bytes.below(2000))};
}

void check_passed(const std::vector<Event>& events, const ValidatorConfig& config) {
  std::int64_t last_us = -Validator::kMaxStamp_us;
  for (const Event& event : events) {
    fuzz::check(config.width == 0 || event.x < config.width);
    fuzz::check(config.height == 0 || event.y < config.height);
    fuzz::check(event.p == 0 || event.p == 1);
    fuzz::check(event.t >= last_us && event.t <= Validator::kMaxStamp_us);
    last_us = event.t;
  }
}

// Returns whether an event was refused, which ends the run.
bool feed(Validator& validator, EventSpan events, std::vector<Event>& passed) {
  try {
    validator.check(events, [&](EventSpan good) {
      fuzz::check(!good.empty());
      passed.insert(passed.end(), good.begin(), good.end());
    });
  } catch (const std::invalid_argument&) {
    fuzz::check(validator.config().on_bad == OnBad::raise);
    fuzz::check(validator.rejected().total() == 1);
    return true;
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const ValidatorConfig config = config_of(bytes);
  const std::size_t piece = 1 + bytes.below(300);
  const std::vector<Event> events = bytes.flag() ? bytes.events(1000) : bytes.stream(1500);
  try {
    Validator whole(config), cut(config);
    std::vector<Event> passed, same;
    const bool refused = feed(whole, events, passed);
    const EventSpan all(events);
    bool cut_refused = false;
    for (std::size_t at = 0; at < all.size() && !cut_refused; at += piece) {
      cut_refused = feed(cut, all.subspan(at, std::min(piece, all.size() - at)), same);
    }
    check_passed(passed, config);
    fuzz::check(whole.received() == passed.size() + whole.rejected().total());
    fuzz::check(refused || whole.received() == events.size());
    fuzz::check(refused == cut_refused && passed == same);
    fuzz::check(whole.rejected() == cut.rejected() && whole.repaired() == cut.repaired());
    fuzz::check(whole.clock_offset_us() == cut.clock_offset_us());
  } catch (const std::invalid_argument& refused) {
    fuzz::check(std::string(refused.what()).find(" = ") != std::string::npos);
  }
  return 0;
}
