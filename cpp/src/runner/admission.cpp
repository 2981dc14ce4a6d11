#include "runner/admission.hpp"

#include <algorithm>

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kMaxAsks = 100'000;  // in one silence; before that, what waited is gone

}  // namespace

void AdmissionGate::pass(EventSpan events, const TimeAxis& axis, const Look& look,
                         const Sink& sink) {
  while (!events.empty()) {
    const std::int64_t first_ns = axis.to_ns(events.front().t);
    if (next_ask_ns_ == kLongAgo) next_ask_ns_ = first_ns;
    next_ask_ns_ = std::max(next_ask_ns_, first_ns - kMaxAsks * admission_.period_ns());
    while (next_ask_ns_ <= first_ns) ask(look);

    const auto end = std::partition_point(events.begin(), events.end(), [&](const Event& e) {
      return axis.to_ns(e.t) < next_ask_ns_;
    });
    const EventSpan period(events.begin(), end);
    admitted_.resize(std::max(admitted_.size(), period.size()));
    const std::size_t size = filter_.apply(period, KeepThreshold::clamped(gamma_), admitted_);
    arrived_ += period.size();
    discarded_ += period.size() - size;
    if (!period.empty()) gap_.thinned(period, {admitted_.data(), size});
    events = events.subspan(period.size());
    sink({admitted_.data(), size});
  }
}

void AdmissionGate::ask(const Look& look) {
  Arrivals arrivals{.now_ns = next_ask_ns_, .arrived = arrived_, .waiting = 0, .oldest_ns = 0};
  look(arrivals);
  gamma_ = admission_.gamma(arrivals);
  arrived_ = 0;
  next_ask_ns_ += admission_.period_ns();
}

}  // namespace asap::inline v0_1
