#include "asap/filter/gamma_filter.hpp"

#include <algorithm>

#include "core/check.hpp"
#include "core/random.hpp"

namespace asap::inline v0_1 {
namespace {

// Precondition: the threshold does not keep all. Then its double has 64 bits, and none is lost.
std::uint64_t bar_of(KeepThreshold threshold) noexcept { return 2 * threshold.value(); }

}  // namespace

KeepThreshold KeepThreshold::checked(double gamma) {
  require(gamma >= 0.0 && gamma <= 1.0, "gamma", gamma, "must be a number between 0 and 1");
  return clamped(gamma);
}

std::size_t GammaFilter::apply(EventSpan events, KeepThreshold threshold,
                               std::span<Event> out) noexcept {
  const std::uint64_t first = position_;
  position_ += events.size();
  if (threshold.keeps_all()) {
    std::copy_n(events.data(), events.size(), out.data());
    return events.size();
  }
  const CounterRandom random(seed_);
  const std::uint64_t bar = bar_of(threshold);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    out[kept] = events[i];
    kept += random(first + i) < bar ? 1U : 0U;
  }
  return kept;
}

void GammaFilter::mask(EventSpan events, KeepThreshold threshold,
                       std::span<std::uint8_t> kept) noexcept {
  const std::uint64_t first = position_;
  position_ += events.size();
  if (threshold.keeps_all()) {
    std::fill_n(kept.begin(), events.size(), std::uint8_t{1});
    return;
  }
  const CounterRandom random(seed_);
  const std::uint64_t bar = bar_of(threshold);
  for (std::size_t i = 0; i < events.size(); ++i) {
    kept[i] = random(first + i) < bar ? 1U : 0U;
  }
}

KeepThreshold GammaFilter::keeping(std::size_t count, std::size_t events,
                                   std::span<std::uint64_t> numbers) const noexcept {
  if (count >= events) return KeepThreshold::all();
  const CounterRandom random(seed_);
  for (std::size_t i = 0; i < events; ++i) numbers[i] = random(position_ + i) >> 1;
  const auto at = [&](std::size_t i) { return numbers.data() + i; };
  std::nth_element(at(0), at(count), at(events));
  return KeepThreshold{numbers[count]};
}

}  // namespace asap::inline v0_1
