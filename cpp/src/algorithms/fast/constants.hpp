// The constants of the engine that a user has no reason to set, with what each is for; those of one
// function stand in it. One setting serves objects of radius 3 to 35 px. Where a range is given, no
// scene changes within it.
#pragma once

#include <cstdint>

namespace asap::inline v0_1::fast {

// ---- cells and times ----

inline constexpr int kCell_px = 4;                // side; to 8
inline constexpr std::uint64_t kTick_us = 1'000;  // period of the work that is not done per event
inline constexpr std::int32_t kLink_us = 40'000;  // memory of a cell's owner; 20 to 80 ms
inline constexpr std::int32_t kSeed_us = 15'000;  // decay of the counts of unassociated events
inline constexpr float kSeed_s = 0.015F;
inline constexpr float kMass_s = 0.03F;  // decay of a track's mass, its number of recent events

// ---- mean and outline ----

inline constexpr std::uint32_t kMeanEvents = 60;         // longest memory of the mean; 40 to 100
inline constexpr std::uint32_t kCovarianceEvents = 300;  // longer: an extent changes slowly
inline constexpr std::uint8_t kContourEvents = 16;       // memory of the radius of one direction
inline constexpr std::uint8_t kKnownContourEvents = 3;   // from which the radius is known
inline constexpr float kContourClip_px = 5;  // so that noise does not pull at the outline
// Least weight of the plain mean, without which a wrong outline would stay; larger values of the
// scale favour the mean.
inline constexpr float kMinMeanWeight = 0.1F;
inline constexpr float kMeanWeightScale = 1.5F;

// ---- gate ----

inline constexpr float kGateScale = 2.3F;    // standard deviations; the edge of a disk lies at 2
inline constexpr float kGatePadding_px = 2;  // in quadrature: the mean has an error
inline constexpr float kMinRadius_px = 7;    // a circle that holds the next step of a small object
inline constexpr float kCircleScale = 2.2F;  // circle: standard deviations of the longest axis ...
inline constexpr float kCirclePadding_px = 5;  // ... and px, for turns
inline constexpr float kMature_s = 0.04F;      // age from which the circle follows the extent

// ---- contact ----

inline constexpr float kContactReach = 1.6F;  // standard deviations between centres; 1.3 to 1.9 ...
inline constexpr float kContactPadding_px = 1;       // ... and px
inline constexpr float kContactVariance_px2 = 0.3F;  // least variance of residuals: whole pixels
inline constexpr float kOwnerCost = 0.8F;         // on the owner's cost: events must not alternate
inline constexpr float kContactGain = 0.6F;       // on the outline's residual
inline constexpr float kContactMeanGain = 0.35F;  // on the mean, where the outline is unknown

// ---- Kalman filter ----

inline constexpr float kAcceleration_px2_s3 = 5e3F;        // density at rest
inline constexpr float kAccelerationPerSpeed_px = 0.055F;  // 1/px, its growth with speed^3
inline constexpr float kMaxAcceleration_px2_s3 = 1e7F;
inline constexpr float kContactAcceleration_px2_s3 = 5e3F;  // as at rest: a neighbour's events pull
inline constexpr float kMeasurementScale = 4;  // on the variance: successive means are correlated
inline constexpr float kMinMeasurement_px2 = 0.05F;  // whole pixels

// ---- life ----

inline constexpr double kSeedEvents = 6;      // unassociated events from which a track begins
inline constexpr double kBirthRate_hz = 300;  // least event rate of an object
inline constexpr float kConfirmEvidence =
    8;                                     // log-likelihood ratio: e^-8 of noise is confirmed ...
inline constexpr float kDropEvidence = 4;  // ... and e^-4 of objects begin twice
inline constexpr double kDieEvents = 2;    // mass below which a track coasts ...
inline constexpr float kDieSigma = 2;      // ... above the noise in its gate, standard deviations
inline constexpr float kStarveRatio = 0.15F;  // share of its rate below which an object has stopped
inline constexpr float kVelocityDecay_s =
    0.1F;                                // without events: it has stopped, or comes out soon
inline constexpr float kHide_s = 0.06F;  // without events, from which it is not listed

// ---- parts of one object ----

inline constexpr float kMergeReach = 1.6F;         // sum of standard deviations ...
inline constexpr float kMergePadding_px = 8;       // ... and px within which two may be one object
inline constexpr float kMergeTolerance_px = 4;     // change of the relative position of its parts
inline constexpr float kMergeRotation_rad = 0.5F;  // and its rotation

}  // namespace asap::inline v0_1::fast
