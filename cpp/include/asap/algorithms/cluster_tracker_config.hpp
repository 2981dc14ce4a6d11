// ClusterTrackerConfig: the parameters of ClusterTracker and their check. One setting serves all
// scenes it was tried on, so none is needed; the ones worth knowing are support_window_ms,
// birth_radius_px (half-extent that a newborn gathers from), max_radius_px and confirm_events.
// In brackets: the parameter's name in the formulas of the headers in fast/.
#pragma once

#include <span>
#include <string_view>
#include <variant>

namespace asap {

// What happens to an event without a recent event among its eight neighbours.
enum class ClusterSupport {
  kOff,       // no question asked; the noise rate is guessed from events that no cluster takes
  kEstimate,  // it counts for the noise rate
  kReject,    // it counts for the noise rate and goes no further
};

struct ClusterTrackerConfig {
  int width;        // px
  int height;       // px
  int slots = 128;  // clusters at a time, tentative ones included, 1 to 256
  int cell_px = 4;  // side of the cells that remember their owner, a power of two

  ClusterSupport support = ClusterSupport::kReject;
  double support_window_ms = 5;  // [baf] age up to which a neighbour is company; where noise is
                                 // rare longer, up to seed_ms

  double tick_ms = 1;     // [tick] period of the work that is not done per event
  double warmup_ms = 30;  // [warm] no births before: the noise rate is being learnt
  double link_ms = 40;    // [tau_link] how long a cell remembers its owner
  double seed_ms = 15;    // [tau_seed] decay of the counters of events without a cluster
  double mass_ms = 30;    // [tau_mass] decay of a cluster's mass, its number of recent events

  int mean_events = 60;         // [n_eff] memory of the mean
  int covariance_events = 300;  // [n_S] memory of the covariance

  double birth_radius_px = 18;   // [Rb] gate of a young cluster
  double min_radius_px = 7;      // [Rmin] smallest circle of a grown one
  double max_radius_px = 40;     // [Rmax] longest half-axis of the elliptic gate
  double gate_scale = 2.3;       // [g] half-axes of the ellipse, standard deviations
  double gate_padding_px = 2;    // [s0] added to the standard deviation, in quadrature
  double circle_scale = 2.2;     // [rk] circle: standard deviations of the longest axis ...
  double circle_padding_px = 5;  // [r0] ... and px
  double mature_ms = 40;         // [mature] age from which the circle adapts

  int contour_events = 16;            // [kn] memory of the outline's radius, per direction
  int contour_min_events = 3;         // [kmin] samples from which a direction is known
  double contour_clip_px = 5;         // [kclip] largest residual that counts
  double contour_min_weight = 0.1;    // [wmin] least weight of the plain mean
  double contour_weight_scale = 1.5;  // [wk] more: trusts the plain mean more

  double contact_gain = 0.6;          // [kgain] of the outline's residual
  double contact_variance_px2 = 0.3;  // [lk] floor of the residual's variance
  double contact_owner_cost = 0.8;    // [hyst] factor on the owner's cost
  double contact_mean_gain = 0.35;    // [cgain] where the outline is unknown
  double contact_reach = 1.6;         // [contactK] standard deviations along the line of centres
  double contact_padding_px = 1;      // [contactPad]

  double acceleration_px2_s3 = 5e3;          // [q0] density of the white acceleration at rest
  double acceleration_per_speed_px = 0.055;  // [q1] its growth with the cube of the speed, 1/px
  double max_acceleration_px2_s3 = 1e7;      // [qmax]
  double contact_acceleration_px2_s3 = 5e3;  // [qc]
  double measurement_scale = 4;              // [rscale] successive means are correlated
  double min_measurement_px2 = 0.05;         // [rmin]

  double seed_events = 6;       // [theta_min] recent events without a cluster that found one
  double confirm_events = 14;   // [m_conf] mass from which a cluster has an id
  double die_events = 2;        // [m_die] mass below which it coasts
  double die_sigma = 2;         // [die_s] margin above the noise in its gate
  double birth_rate_hz = 300;   // [rho0] least event rate of an object
  double confirm_evidence = 8;  // [llr_conf] log-likelihood ratio of object against noise ...
  double drop_evidence = 4;     // [-llr_die] ... and of noise against object
  double starve_ratio = 0.15;   // [starve] of the usual event rate: below, the object has stopped
  double velocity_decay_ms = 100;  // [vdec] of a cluster without events
  double hide_ms = 60;             // [hide] stopped for longer: not listed
  double coast_ms = 250;           // [coast] time from too little mass to deletion

  double merge_reach = 1.6;         // [mK] sum of standard deviations ...
  double merge_padding_px = 8;      // [mPad] ... and px within which two may be one
  double merge_tolerance_px = 4;    // [mtol] change of the relative position of two parts of one
  double merge_rotation_rad = 0.5;  // [mrot] and its rotation
};

// Returns its argument; throws std::invalid_argument that names the first bad field.
const ClusterTrackerConfig& checked(const ClusterTrackerConfig& config);

// A parameter by name: what bindings need to take, list and refuse them without naming each.
struct ClusterTrackerParameter {
  std::string_view name;
  std::variant<int ClusterTrackerConfig::*, double ClusterTrackerConfig::*> field;
};

// All but width, height and support, in the order above.
std::span<const ClusterTrackerParameter> cluster_tracker_parameters() noexcept;

}  // namespace asap
