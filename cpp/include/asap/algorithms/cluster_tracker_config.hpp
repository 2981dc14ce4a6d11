// ClusterTrackerConfig: the parameters of ClusterTracker and their check. One setting serves all
// scenes it was tried on, so most users change none. The most useful ones are support_window_ms,
// birth_radius_px (least radius within which a new cluster takes events), max_radius_px and
// confirm_events. Plain data, any thread; checked() throws std::invalid_argument.
#pragma once

#include <span>
#include <string_view>
#include <variant>

namespace asap {

// What happens to an event without support: without a recent event among its eight neighbours.
enum class ClusterSupport {
  kOff,       // support is not computed; the noise rate follows from events that no cluster takes
  kEstimate,  // the event counts for the noise rate
  kReject,    // the event counts for the noise rate and goes to no cluster
};

struct ClusterTrackerConfig {
  int width;        // px
  int height;       // px
  int slots = 128;  // clusters at a time, tentative ones included, 1 to 256
  int cell_px = 4;  // side of the cells that remember their owner, a power of two

  ClusterSupport support = ClusterSupport::kReject;
  double support_window_ms = 5;  // greatest age of a neighbour that gives support; in little noise
                                 // it grows, up to seed_ms

  double tick_ms = 1;     // period of the work that is not done per event
  double warmup_ms = 12;  // no cluster begins before, while the noise rate is being measured
  double link_ms = 40;    // for which a cell remembers its owner
  double seed_ms = 15;    // decay of the counts of events without a cluster
  double mass_ms = 30;    // decay of a cluster's mass, its number of recent events

  int mean_events = 60;         // longest memory of the mean; a small object has a shorter one
  int covariance_events = 300;  // memory of the covariance

  double birth_radius_px = 18;   // circular gate of a young cluster; alone, up to 5/3 of it
  double min_radius_px = 7;      // smallest circle of a mature one
  double max_radius_px = 66;     // longest half-axis of the elliptic gate
  double gate_scale = 2.3;       // half-axes of the ellipse, standard deviations; some have .4 more
  double gate_padding_px = 2;    // added to the standard deviation, in quadrature
  double circle_scale = 2.2;     // circle: standard deviations of the longest axis ...
  double circle_padding_px = 5;  // ... and px
  double mature_ms = 40;         // age from which the circle follows the extent

  int contour_events = 16;            // memory of the outline's radius, per direction
  int contour_min_events = 3;         // events from which the radius of a direction is known
  double contour_clip_px = 5;         // largest residual that counts
  double contour_min_weight = 0.1;    // least weight of the plain mean
  double contour_weight_scale = 1.5;  // larger values favour the plain mean

  double contact_gain = 0.6;          // on the outline's residual
  double contact_variance_px2 = 0.3;  // floor of the residual's variance
  double contact_owner_cost = 0.8;    // factor on the owner's cost
  double contact_mean_gain = 0.35;    // on the mean, where the outline is unknown
  double contact_reach = 1.6;         // standard deviations along the line of centres ...
  double contact_padding_px = 1;      // ... and px within which two clusters are in contact

  double acceleration_px2_s3 = 5e3;          // density of the white acceleration at rest
  double acceleration_per_speed_px = 0.055;  // its growth with the cube of the speed, 1/px
  double max_acceleration_px2_s3 = 1e7;      // its maximum
  double contact_acceleration_px2_s3 = 5e3;  // its value in contact
  double measurement_scale = 4;              // on the variance: successive means are correlated
  double min_measurement_px2 = 0.05;         // least variance of a measurement

  double seed_events = 6;          // recent events without a cluster from which one begins
  double confirm_events = 14;      // mass from which a cluster has an id; a small one 4/7 of it
  double die_events = 2;           // mass below which it coasts
  double die_sigma = 2;            // margin above the noise in its gate, standard deviations
  double birth_rate_hz = 300;      // least event rate of an object
  double confirm_evidence = 8;     // log-likelihood ratio of an object against noise ...
  double drop_evidence = 4;        // ... and of noise against an object
  double starve_ratio = 0.15;      // of the average event rate: below, the object has stopped
  double velocity_decay_ms = 100;  // of a cluster without events
  double hide_ms = 60;             // stopped for longer: not listed
  double coast_ms = 250;           // from too little mass to deletion

  double merge_reach = 1.6;         // sum of standard deviations ...
  double merge_padding_px = 8;      // ... and px within which two clusters may be one object
  double merge_tolerance_px = 4;    // change of the relative position of two parts of one object
  double merge_rotation_rad = 0.5;  // and its rotation
};

// Returns its argument; throws std::invalid_argument that names the first bad field.
const ClusterTrackerConfig& checked(const ClusterTrackerConfig& config);

// A parameter by name, so that bindings can set, list and check all without naming each.
struct ClusterTrackerParameter {
  std::string_view name;
  std::variant<int ClusterTrackerConfig::*, double ClusterTrackerConfig::*> field;
};

// All but width, height and support, in the order above.
std::span<const ClusterTrackerParameter> cluster_tracker_parameters() noexcept;

}  // namespace asap
