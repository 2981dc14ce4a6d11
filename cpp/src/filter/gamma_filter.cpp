#include "asap/filter/gamma_filter.hpp"

#include <algorithm>

#include "asap/core/check.hpp"

namespace asap {

KeepThreshold KeepThreshold::checked(double gamma) {
  require(gamma >= 0.0 && gamma <= 1.0, "gamma", gamma, "must be a number between 0 and 1");
  return clamped(gamma);
}

std::size_t GammaFilter::apply(EventSpan events, KeepThreshold threshold, Event* out) noexcept {
  const std::uint64_t first = position_;
  position_ += events.size();
  if (threshold.keeps_all()) {
    std::copy_n(events.data(), events.size(), out);
    return events.size();
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    out[kept] = events[i];
    kept += keeps(first + i, threshold) ? 1U : 0U;
  }
  return kept;
}

void GammaFilter::mask(EventSpan events, KeepThreshold threshold, std::uint8_t* kept) noexcept {
  const std::uint64_t first = position_;
  position_ += events.size();
  if (threshold.keeps_all()) {
    std::fill_n(kept, events.size(), std::uint8_t{1});
    return;
  }
  for (std::size_t i = 0; i < events.size(); ++i) {
    kept[i] = keeps(first + i, threshold) ? 1U : 0U;
  }
}

KeepThreshold GammaFilter::keeping(std::size_t count, std::size_t events,
                                   std::uint64_t* numbers) const noexcept {
  if (count >= events) return KeepThreshold::all();
  for (std::size_t i = 0; i < events; ++i) numbers[i] = random_(position_ + i) >> 1;
  std::nth_element(numbers, numbers + count, numbers + events);
  return KeepThreshold{numbers[count]};
}

}  // namespace asap
