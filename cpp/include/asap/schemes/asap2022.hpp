// Asap2022: the scheme of the node that its authors published with Tapia, Martinez-de Dios, Gomez
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
// clipped to [0, 1]. Flush at the bound. On the consumer's thread; O(1), no allocation.
//
//   Asap2022 scheme;
//   Pipeline pipeline{scheme, {.latency = 10ms}};
#pragma once

#include <chrono>
#include <cstddef>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

struct Asap2022Config {
  std::chrono::nanoseconds min_processing = std::chrono::microseconds(200);  // limits of H
  std::chrono::nanoseconds max_processing = std::chrono::milliseconds(10);
  std::size_t min_size = 100;
  std::size_t max_size = 29'700;
  double kappa = 1.0;  // steepness of the size rule
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

class Asap2022 final : public LearningScheme {
 public:
  using Config = Asap2022Config;

  explicit Asap2022(Config config = {});
};

}  // namespace asap::inline v0_1
