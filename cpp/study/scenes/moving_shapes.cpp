#include "study/scenes/moving_shapes.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "core/random.hpp"
#include "study/portable_math.hpp"
#include "synthetic/scene_checks.hpp"

namespace asap {
namespace {

// When a level that goes linearly from `from` to `to` crosses `crossed`.
std::int32_t crossing_us(double crossed, double from, double to, std::int32_t step_us) noexcept {
  const double way = to - from;
  const double gone = crossed - from;
  if (way == 0.0) return 0;
  const double offset_us = std::clamp(gone / way, 0.0, 1.0) * step_us;
  return std::min(static_cast<std::int32_t>(offset_us), step_us - 1);
}

}  // namespace

std::optional<ContrastPixel::Change> ContrastPixel::move_to(double level, std::int64_t start_us,
                                                            std::int32_t step_us) noexcept {
  std::optional<Change> seen;
  const auto crossed = [&](bool on) {
    const std::int32_t offset_us = crossing_us(reference_, level_, level, step_us);
    if (start_us + offset_us < blind_until_us_) return;
    blind_until_us_ = start_us + offset_us + kRefractory_us;
    seen = {offset_us, on};
  };
  while (level - reference_ >= on_) {
    reference_ += on_;
    crossed(true);
  }
  while (reference_ - level >= off_) {
    reference_ -= off_;
    crossed(false);
  }
  level_ = level;
  return seen;
}

namespace {

constexpr double kContrast = 0.25;        // mean threshold, in log brightness
constexpr double kContrastSpread = 0.12;  // of the pixels, relative
constexpr double kLeastContrast = 0.1;
constexpr double kLeastBrightness = 0.02;
constexpr std::size_t kMaxShapes = 10'000;

static_assert(MovingShapes::kStep_us <= ContrastPixel::kRefractory_us,
              "a pixel fires once in a step at most");

const MovingShapesConfig& checked(const MovingShapesConfig& config) {
  synthetic::require_view_and_time(config.width, config.height, config.duration_us, config.t0_us);
  require(config.duration_us % MovingShapes::kStep_us == 0, "duration_us", config.duration_us,
          "give a multiple of 250 us");
  require(config.shapes.size() <= kMaxShapes, "shapes", config.shapes.size(),
          "give 10000 shapes at most");
  require(config.decoys <= config.shapes.size(), "decoys", config.decoys,
          "give no more than there are shapes");
  for (const MovingShape& shape : config.shapes) {
    require(shape.brightness >= kLeastBrightness && shape.brightness <= 1.0, "brightness",
            shape.brightness, "give 0.02 to 1");
    constexpr std::int64_t kLeast_us = 2 * MovingShapes::kStep_us;
    const Flicker& flicker = shape.flicker;
    require(flicker.period_us >= 0 && flicker.period_us % kLeast_us == 0, "flicker.period_us",
            flicker.period_us, "give a multiple of 500 us");
    require(flicker.begun_us >= 0 && flicker.begun_us <= flicker.period_us, "flicker.begun_us",
            flicker.begun_us, "give 0 to the period");
  }
  return config;
}

std::vector<RigidShape> shapes_of(const MovingShapesConfig& config) {
  std::vector<RigidShape> shapes;
  for (const MovingShape& shape : config.shapes) {
    shapes.emplace_back(shape.kind, shape.radius_px, shape.thickness_px);
  }
  return shapes;
}

std::vector<std::vector<Limb>> limbs_of(const MovingShapesConfig& config) {
  std::vector<std::vector<Limb>> limbs;
  for (const MovingShape& shape : config.shapes) {
    limbs.emplace_back(shape.limbs.begin(), shape.limbs.end());
  }
  return limbs;
}

std::vector<std::optional<Texture>> textures_of(const MovingShapesConfig& config) {
  constexpr double kPitch_px = 5.0;
  const CounterRandom seeds{CounterRandom(config.seed)(3)};
  std::vector<std::optional<Texture>> textures(config.shapes.size());
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const MovingShape& shape = config.shapes[i];
    const double high = std::min(1.6, 1.0 / shape.brightness);
    if (shape.textured) textures[i].emplace(CounterRandom(seeds(i)), kPitch_px, 0.4, high);
  }
  return textures;
}

std::optional<MovingGround> ground_of(const MovingShapesConfig& config) {
  if (!config.ground) return std::nullopt;
  return MovingGround(*config.ground, config.width, config.height,
                      CounterRandom(CounterRandom(config.seed)(4)));
}

std::optional<Fence> fence_of(const MovingShapesConfig& config) {
  if (!config.fence) return std::nullopt;
  return Fence(*config.fence, config.width, config.height);
}

std::vector<RigidMotion> motions_of(std::span<const MovingShape> shapes) {
  std::vector<RigidMotion> motions;
  for (const MovingShape& shape : shapes) motions.emplace_back(shape.motion);
  return motions;
}

double brightness_at(const MovingShape& shape, std::int64_t t_us) noexcept {
  const auto [period_us, begun_us] = shape.flicker;
  const bool is_lit = period_us == 0 || (t_us + begun_us) % period_us < period_us / 2;
  return is_lit ? shape.brightness : MovingShapes::kGround;
}

double level_of(double brightness) noexcept {
  return synthetic::portable_log(std::max(kLeastBrightness, brightness));
}

std::size_t pixels_of(const MovingShapesConfig& config) noexcept {
  return static_cast<std::size_t>(config.width) * static_cast<std::size_t>(config.height);
}

}  // namespace

MovingShapes::MovingShapes(const MovingShapesConfig& config)
    : config_(checked(config)),
      shapes_(shapes_of(config)),
      motions_(motions_of(config.shapes)),
      limbs_(limbs_of(config)),
      textures_(textures_of(config)),
      ground_(ground_of(config)),
      fence_(fence_of(config)),
      canvas_(config.width, config.height, kGround),
      noise_(config.width, config.height, config.noise_hz, CounterRandom(config.seed)(0)),
      pixels_(pixels_of(config)),
      shown_(pixels_of(config)),
      seen_block_(config.width, config.height, pixels_of(config)),
      noise_block_(config.width, config.height, kStep_us),
      events_(pixels_of(config) + kStep_us),
      labels_(events_.size()),
      poses_(config.shapes.size()) {
  paint(0);
  make_pixels();
}

EventSpan MovingShapes::next() noexcept {
  size_ = 0;
  while (elapsed_us_ < config_.duration_us) {
    advance();
    paint(elapsed_us_ + kStep_us);

    seen_block_.open(config_.t0_us + elapsed_us_, kStep_us);
    noise_block_.open(config_.t0_us + elapsed_us_, kStep_us);
    see();
    noise_.add_to(noise_block_, elapsed_us_);
    elapsed_us_ += kStep_us;
    merge(seen_block_.close(), noise_block_.close());
    if (size_ > 0) break;
  }
  return {events_.data(), size_};
}

void MovingShapes::make_pixels() {
  const CounterRandom random{CounterRandom(config_.seed)(1)};
  const CounterRandom offsets{CounterRandom(config_.seed)(2)};
  const auto threshold = [&](std::uint64_t number) {
    const double spread = kContrastSpread * synthetic::near_normal(random, number);
    return std::max(kLeastContrast, kContrast * (1.0 + spread));
  };
  for (std::uint32_t pixel = 0; pixel < pixels_.size(); ++pixel) {
    const std::uint64_t number = pixel;
    const double on = threshold(2 * number);
    const double off = threshold(2 * number + 1);
    const double brightness = canvas_.brightness(pixel);
    shown_[pixel] = through_fence(pixel, brightness);
    const double level = level_of(shown_[pixel]);
    const double offset = brightness == kGround ? offsets.uniform(number) - 0.5 : 0.0;
    pixels_[pixel] = ContrastPixel(on, off, level, level + kContrast * offset);
  }
}

void MovingShapes::advance() noexcept {
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    poses_[i] = motions_[i].pose();
    motions_[i].advance();
    for (Limb& limb : limbs_[i]) limb.advance();
  }
  if (ground_) ground_->advance(kStep_us);
}

void MovingShapes::paint(std::int64_t t_us) noexcept {
  if (ground_) {
    canvas_.begin(*ground_);
  } else {
    canvas_.begin();
  }
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    const Pose& pose = motions_[i].pose();
    const double brightness = brightness_at(config_.shapes[i], t_us);
    const bool is_object = i + config_.decoys < shapes_.size();
    const auto object = is_object ? static_cast<std::int32_t>(i) : ShapeCanvas::kNone;
    const Texture* texture = textures_[i] ? &*textures_[i] : nullptr;
    canvas_.paint(shapes_[i], pose, brightness, object, texture);
    for (const Limb& limb : limbs_[i]) {
      canvas_.paint(limb.shape(), limb.on(pose), brightness, object);
    }
  }
}

double MovingShapes::through_fence(std::uint32_t pixel, double brightness) const noexcept {
  return fence_ ? fence_->before(pixel, brightness) : brightness;
}

void MovingShapes::see() noexcept {
  const auto width = static_cast<std::uint32_t>(config_.width);
  for (const std::uint32_t pixel : canvas_.touched()) {
    const double brightness = through_fence(pixel, canvas_.brightness(pixel));
    if (brightness == shown_[pixel]) continue;
    shown_[pixel] = brightness;
    const auto change = pixels_[pixel].move_to(level_of(brightness), elapsed_us_, kStep_us);
    if (!change) continue;
    seen_block_.add(static_cast<std::int32_t>(pixel % width),
                    static_cast<std::int32_t>(pixel / width), change->on, change->offset_us);
  }
}

// Both are in time order; what the shapes caused goes first at equal times.
void MovingShapes::merge(EventSpan seen, EventSpan noise) noexcept {
  const auto width = static_cast<std::uint32_t>(config_.width);
  auto next_noise = noise.begin();
  const auto add = [&](const Event& event, std::int32_t label) {
    events_[size_] = event;
    labels_[size_++] = label;
  };
  for (const Event& event : seen) {
    for (; next_noise != noise.end() && next_noise->t < event.t; ++next_noise) {
      add(*next_noise, kNoise);
    }
    add(event, canvas_.owner(event.x + width * event.y));
  }
  for (; next_noise != noise.end(); ++next_noise) add(*next_noise, kNoise);
}

std::span<const MovingShape> objects_of(const MovingShapesConfig& config) noexcept {
  return {config.shapes.data(), config.shapes.size() - config.decoys};
}

double reach_px(const MovingShape& shape) {
  double reach = RigidShape(shape.kind, shape.radius_px, shape.thickness_px).reach_px();
  for (const LimbConfig& limb : shape.limbs) {
    const double joint_px = std::sqrt(limb.joint.x * limb.joint.x + limb.joint.y * limb.joint.y);
    reach = std::max(reach, joint_px + limb.length_px + 0.5 * limb.width_px);
  }
  return reach;
}

std::vector<Pose> poses_of(const MovingShapesConfig& config) {
  std::vector<RigidMotion> motions = motions_of(objects_of(checked(config)));
  std::vector<Pose> poses;
  poses.reserve(motions.size() *
                (static_cast<std::size_t>(config.duration_us / MovingShapes::kStep_us) + 1));
  for (std::int64_t t_us = 0; t_us <= config.duration_us; t_us += MovingShapes::kStep_us) {
    for (RigidMotion& motion : motions) {
      poses.push_back(motion.pose());
      motion.advance();
    }
  }
  return poses;
}

}  // namespace asap
