#include "algorithms/fast/position_error.hpp"

#include <algorithm>

#include "algorithms/fast/decay.hpp"
#include "algorithms/fast/gate.hpp"

namespace asap::fast {
namespace {

constexpr float kTravel_extents = 2;  // in which the doubt falls to 1/e
constexpr float kContactDoubt = 0.08F;
constexpr float kContact_s = 0.14F;
constexpr float kLeastExtent_px = 1;

}  // namespace

void doubt_outline(Contour& contour, const Track& track, float extent_px, float dt_s) noexcept {
  const bool in_contact = track.partners > 0;
  const float travel_extents =
      length(track.vx, track.vy) * dt_s / std::max(kLeastExtent_px, extent_px);
  const float left = decay(in_contact ? dt_s / kContact_s : travel_extents / kTravel_extents);
  const float end = in_contact ? kContactDoubt : kLeastDoubt;
  contour.doubt = end + (contour.doubt - end) * left;
}

PositionError position_error(const Track& track, const KalmanState& state, const Contour& contour,
                             Stamp now, const KalmanRule& rule) noexcept {
  const float variance = position_variance(track, state, now, rule);
  return {variance + contour.doubt * track.sxx, contour.doubt * track.sxy,
          variance + contour.doubt * track.syy};
}

}  // namespace asap::fast
