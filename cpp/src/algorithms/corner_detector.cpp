#include "asap/algorithms/corner_detector.hpp"

#include <bit>

#include "algorithms/arc_filter.hpp"
#include "algorithms/arc_length.hpp"
#include "algorithms/corner_ring.hpp"
#include "algorithms/harris_score.hpp"
#include "algorithms/newest_patch.hpp"
#include "algorithms/order_surface.hpp"
#include "algorithms/sensor_frame.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

using Number = OrderSurface::Number;

// Whether the newest pixels, `shortest` to `longest` of them, are an arc. If they are, the arc that
// grows from the newest is never left before it has them all.
template <class Ring>
bool has_newest_arc(const Ring& ring, int shortest, int longest) noexcept {
  GrowingArc arc(ring);
  int length = shortest;
  while (length <= longest) {
    arc.grow_to(length);
    const int as_new = std::popcount(ring.at_least(arc.oldest()));
    if (as_new == length) return true;
    length = as_new;  // a shorter arc would leave out some of these
  }
  return false;
}

}  // namespace

// The half that the Harris detectors share: the order in which the pixels fired, and the score of
// the newest of them.
class HarrisPatch {
 public:
  HarrisPatch(const SensorFrame& frame, double threshold)
      : threshold_(checked_threshold(threshold)), arrivals_(frame) {}

  void take(const Event& event) noexcept { *arrivals_.pixel(event) = arrivals_.next(); }

  // Precondition: it took this event last.
  bool is_corner(const Event& event) noexcept {
    PatchRows rows;
    return patch_.select(arrivals_.pixel(event), arrivals_.stride(), rows) &&
           harris_score(rows) > threshold_;
  }

  void clear() noexcept {
    arrivals_.clear();
    patch_.clear();
  }

 private:
  double threshold_;
  OrderSurface arrivals_;  // numbers events, not timestamps: a patch has no ties
  NewestPatch patch_;
};

// A rule checks its configuration in the constructor. take() sees every event in the frame, and
// returns whether it may be a corner; is_corner() may be asked about the last one taken, if so.

class EFastRule {
 public:
  explicit EFastRule(const EFastConfig& config)
      : frame_(config.width, config.height), surface_(frame_) {}

  const SensorFrame& frame() const noexcept { return frame_; }

  bool take(const Event& event) noexcept {
    *surface_.pixel(event) = surface_.next(event.t);
    return frame_.contains(event, kRingMargin);
  }
  bool is_corner(const Event& event) noexcept {
    const Number* pixel = surface_.pixel(event);
    return has_newest_arc(CornerRing<kRing3>(pixel, surface_.stride()), 3, 6) &&
           has_newest_arc(CornerRing<kRing4>(pixel, surface_.stride()), 4, 8);
  }

  void clear() noexcept { surface_.clear(); }

 private:
  SensorFrame frame_;
  OrderSurface surface_;
};

class ArcStarRule {
 public:
  explicit ArcStarRule(const ArcStarConfig& config)
      : frame_(config.width, config.height),
        filter_(frame_, config.filter.count()),
        surface_(frame_) {}

  const SensorFrame& frame() const noexcept { return frame_; }

  bool take(const Event& event) noexcept {
    if (!filter_.passes(event)) return false;
    *surface_.pixel(event) = surface_.next(filter_.now_us());
    return frame_.contains(event, kRingMargin);
  }
  bool is_corner(const Event& event) noexcept {
    return has_corner_arcs(surface_.pixel(event), surface_.stride());
  }

  void clear() noexcept {
    filter_.clear();
    surface_.clear();
  }

 private:
  SensorFrame frame_;
  ArcFilter filter_;
  OrderSurface surface_;  // holds the events that passed
};

class EHarrisRule {
 public:
  explicit EHarrisRule(const EHarrisConfig& config)
      : frame_(config.width, config.height), patch_(frame_, config.threshold) {}

  const SensorFrame& frame() const noexcept { return frame_; }

  bool take(const Event& event) noexcept {
    patch_.take(event);
    return has_window(event);
  }
  bool is_corner(const Event& event) noexcept { return patch_.is_corner(event); }

  void clear() noexcept { patch_.clear(); }

 private:
  // One column and row more than the rings have: the window reaches into the padding there.
  bool has_window(const Event& event) const noexcept {
    return event.x >= 4 && event.x + 4U <= frame_.width() && event.y >= 4 &&
           event.y + 4U <= frame_.height();
  }

  SensorFrame frame_;
  HarrisPatch patch_;
};

class FAHarrisRule {
 public:
  explicit FAHarrisRule(const FAHarrisConfig& config)
      : frame_(config.width, config.height),
        patch_(frame_, config.threshold),
        filter_(frame_, config.filter.count()),
        stamps_(frame_) {}

  const SensorFrame& frame() const noexcept { return frame_; }

  bool take(const Event& event) noexcept {
    if (!frame_.contains(event, kRingMargin)) {
      filter_.pass_over(event);
      return false;
    }
    if (!filter_.passes(event)) return false;
    *stamps_.pixel(event) = stamps_.next(filter_.now_us());
    patch_.take(event);
    return true;
  }
  bool is_corner(const Event& event) noexcept {
    return has_corner_arcs(stamps_.pixel(event), stamps_.stride()) && patch_.is_corner(event);
  }

  void clear() noexcept {
    filter_.clear();
    stamps_.clear();
    patch_.clear();
  }

 private:
  SensorFrame frame_;
  HarrisPatch patch_;  // holds the events that passed
  ArcFilter filter_;
  OrderSurface stamps_;  // holds the same events for the arcs, where equal timestamps are ties
};

namespace {

// Whether an event may be a corner; false, and counted, if it lies outside the frame.
template <class Rule>
bool take(Rule& rule, const Event& event, std::uint64_t& rejected) noexcept {
  if (!rule.frame().contains(event)) [[unlikely]] {
    ++rejected;
    return false;
  }
  return rule.take(event);
}

}  // namespace

template <class Rule, class Configuration>
CornerDetector<Rule, Configuration>::CornerDetector(const Config& config)
    : config_(config), rule_(std::make_unique<Rule>(config)) {}
template <class Rule, class Configuration>
CornerDetector<Rule, Configuration>::~CornerDetector() = default;
template <class Rule, class Configuration>
CornerDetector<Rule, Configuration>::CornerDetector(CornerDetector&&) noexcept = default;
template <class Rule, class Configuration>
CornerDetector<Rule, Configuration>& CornerDetector<Rule, Configuration>::operator=(
    CornerDetector&&) noexcept = default;

template <class Rule, class Configuration>
std::size_t CornerDetector<Rule, Configuration>::process(EventSpan events) noexcept {
  Rule& rule = *rule_;
  std::size_t corners = 0;
  for (const Event& event : events) {
    corners += take(rule, event, rejected_) && rule.is_corner(event);
  }
  return corners;
}

template <class Rule, class Configuration>
void CornerDetector<Rule, Configuration>::process(EventSpan events,
                                                  std::span<std::uint8_t> corners) {
  require(corners.size() == events.size(), "corners.size()", corners.size(),
          "must be the number of events");
  Rule& rule = *rule_;
  for (std::size_t i = 0; i < events.size(); ++i) {
    corners[i] = take(rule, events[i], rejected_) && rule.is_corner(events[i]);
  }
}

template <class Rule, class Configuration>
void CornerDetector<Rule, Configuration>::process(EventSpan events, std::span<std::uint8_t> corners,
                                                  const std::uint32_t* places) noexcept {
  Rule& rule = *rule_;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const bool may_be = take(rule, events[i], rejected_);
    if (places[i] < corners.size()) corners[places[i]] = may_be && rule.is_corner(events[i]);
  }
}

template <class Rule, class Configuration>
void CornerDetector<Rule, Configuration>::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

template <class Rule, class Configuration>
void CornerDetector<Rule, Configuration>::reset() noexcept {
  rule_->clear();
  rejected_ = 0;
}

template class CornerDetector<EFastRule, EFastConfig>;
template class CornerDetector<ArcStarRule, ArcStarConfig>;
template class CornerDetector<EHarrisRule, EHarrisConfig>;
template class CornerDetector<FAHarrisRule, FAHarrisConfig>;

}  // namespace asap::inline v0_1
