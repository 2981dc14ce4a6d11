// An algorithm of your own: the event rate in each tile of the image. When events are discarded, a
// kept one stands for several: the package says how many. Continuity: none are dropped in a row.
#include <asap/runner/simulator.hpp>
#include <asap/schemes/deadline.hpp>
#include <asap/synthetic/streams.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <iostream>

namespace {

class RateMap {
 public:
  void set_gamma(double gamma) noexcept { weight_ = 1.0 / gamma; }  // the share that is kept

  void process(asap::EventSpan events) noexcept {
    for (const asap::Event& event : events) {
      Tile& tile = tiles_[event.y / kTile_px][event.x / kTile_px];
      tile.count *= std::exp(static_cast<double>(tile.t - event.t) / kMemory_us);
      tile.count += weight_;
      tile.t = event.t;
    }
  }

  double rate_hz(std::size_t x, std::size_t y) const noexcept {
    return tiles_[y / kTile_px][x / kTile_px].count / (kMemory_us * 1e-6);
  }

 private:
  struct Tile {
    double count = 0.0;  // of recent events; it fades
    std::int64_t t = 0;
  };
  static constexpr std::size_t kTile_px = 64;
  static constexpr double kMemory_us = 20'000.0;
  std::array<std::array<Tile, 6>, 5> tiles_;  // of 346 x 260 px
  double weight_ = 1.0;
};

}  // namespace

int main() {
  RateMap all, told, not_told;
  const asap::Consumer process = [&](const asap::Package& package) {
    told.set_gamma(package.gamma);
    told.process(package.events);
    not_told.process(package.events);
  };
  asap::ShakenPattern scene{{.duration = std::chrono::milliseconds(500)}};
  asap::Deadline scheme{{.prefer = asap::Prefer::continuity}};
  asap::Simulator simulator{scheme, asap::LinearCost{{.beta_ns = 300}}, {}, process};
  for (auto events = scene.next(); !events.empty(); events = scene.next()) {
    all.process(events);
    simulator.feed(events);
  }
  simulator.finish();
  std::cout << "In the middle " << all.rate_hz(173, 130) << " ev/s, told " << told.rate_hz(173, 130)
            << ", not told " << not_told.rate_hz(173, 130) << '\n';
}
