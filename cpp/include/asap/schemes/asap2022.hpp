// Asap2022: the law of the node that its authors published with Tapia, Martinez-de Dios, Gomez
// Eguiluz, Ollero, Autonomous Robots 46, 2022, in pull form. A baseline: keep Deadline for work.
//
//   size    S atan(kappa ln H) + c, H in ms: min_size at the least processing time, max_size at the
//           longest. It does not see the event rate, and may have two stable values
//   gamma   top - (r - r_min) / (r_max - r_min) (top - min_gamma); r = 500 / (time of the last 500
//           containers), r_max and r_min leak by 1 % per container towards each other, top falls
//           from max_gamma to min_gamma as H grows. At a constant rate gamma chatters, 0.7 on
//           average
//
// Containers are the driver's, counted over the events that leave the ring. There is no start-up
// lock: top begins at max_gamma; and no NaN: the 500 containers take at least 1 us, gamma is
// clipped to [0, 1]. Flush at the latency bound. O(1) per package and container, no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap {

// DriverContainers: cuts a stream where a camera driver would have delivered it, after 1000 events
// or 20 ms, whichever comes first; empty times deliver nothing. Asap2022 counts its rate in such
// containers. It is told of many events at once and spreads them evenly over their time. O(1) per
// container, no allocation.
class DriverContainers {
 public:
  static constexpr std::size_t kEvents = 1000;
  static constexpr std::int64_t kLongestNs = 20'000'000;

  // `count` more events, spread over [from_ns, until_ns); deliver(time_ns) for each container that
  // they complete. Time does not go back.
  template <class Deliver>
  void pass(std::size_t count, std::int64_t from_ns, std::int64_t until_ns, Deliver&& deliver) {
    if (!is_begun_) begin_ns_ = from_ns;
    is_begun_ = true;
    const double step_ns =
        (static_cast<double>(until_ns) - static_cast<double>(from_ns)) / static_cast<double>(count);
    const auto time_ns = [&](std::size_t i) {
      return from_ns + static_cast<std::int64_t>(static_cast<double>(i) * step_ns);
    };
    for (std::size_t i = 0; i < count;) {
      const std::int64_t timeout_ns = begin_ns_ + kLongestNs;
      const std::size_t in_time = std::max(i, before(timeout_ns, from_ns, step_ns, count));
      if (in_time - i >= left()) {
        i += left();
        held_ = 0;
        begin_ns_ = time_ns(i - 1);
        deliver(begin_ns_);
      } else if (in_time == count) {
        held_ += count - i;
        i = count;
      } else if (held_ + (in_time - i) > 0) {
        i = in_time;
        held_ = 0;
        deliver(timeout_ns);
      } else {
        begin_ns_ += (time_ns(i) - begin_ns_) / kLongestNs * kLongestNs;
        held_ = 1;
        ++i;
      }
    }
  }

  // Events until the open container is full, at least 1.
  std::size_t left() const noexcept { return kEvents - held_; }

 private:
  // How many of the events lie before this time.
  static std::size_t before(std::int64_t time_ns, std::int64_t from_ns, double step_ns,
                            std::size_t count) noexcept {
    const double ahead_ns = static_cast<double>(time_ns) - static_cast<double>(from_ns);
    if (ahead_ns <= 0) return 0;
    const double events = std::ceil(ahead_ns / step_ns);  // infinite for equal times
    return events < static_cast<double>(count) ? static_cast<std::size_t>(events) : count;
  }

  std::size_t held_ = 0;  // events of the open container, < kEvents
  std::int64_t begin_ns_ = 0;
  bool is_begun_ = false;
};

struct Asap2022Config {
  std::chrono::nanoseconds min_processing = std::chrono::microseconds(200);  // limits of H
  std::chrono::nanoseconds max_processing = std::chrono::milliseconds(10);
  std::size_t min_size = 100;
  std::size_t max_size = 29'700;
  double kappa = 1.0;  // steepness of the size law
  double min_gamma = 0.1;
  double max_gamma = 1.0;
  std::size_t first_size = 1000;

  static constexpr std::tuple kParameters{
      NamedField{"min_processing_ms", &Asap2022Config::min_processing},
      NamedField{"max_processing_ms", &Asap2022Config::max_processing},
      NamedField{"min_size", &Asap2022Config::min_size},
      NamedField{"max_size", &Asap2022Config::max_size},
      NamedField{"kappa", &Asap2022Config::kappa},
      NamedField{"min_gamma", &Asap2022Config::min_gamma},
      NamedField{"max_gamma", &Asap2022Config::max_gamma},
      NamedField{"first_size", &Asap2022Config::first_size},
  };
};

class Asap2022 final : public Scheme {
 public:
  using Config = Asap2022Config;

  explicit Asap2022(Config config = {});

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "asap2022"; }
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  static constexpr std::size_t kWindow = 500;  // containers

  void pass_containers(std::int64_t oldest_ns) noexcept;
  void adapt_gamma(std::int64_t container_ns) noexcept;
  void adapt_size(double processing_ms) noexcept;
  double kept_of(double raw) const noexcept;
  std::size_t raw_for_size() const noexcept;

  const Asap2022Config config_;
  double scale_;  // S

  double size_;  // a whole number
  double top_gamma_;
  double gamma_;       // of the open container
  double mean_gamma_;  // of the last containers
  double r_max_;       // containers per second
  double r_min_;

  DriverContainers containers_;
  std::array<std::int64_t, kWindow> container_ns_{};
  std::uint64_t container_count_ = 0;

  // The take that is not yet counted into containers.
  std::size_t taken_ = 0;
  std::int64_t asked_oldest_ns_ = 0;
  std::int64_t asked_now_ns_ = 0;
};

}  // namespace asap
