#include "packager/kept_mask.hpp"

#include <algorithm>

#include "asap/core/nonblocking.hpp"

namespace asap::inline v0_1 {

void KeptMask::make_room(std::size_t events) {
  delivered_.make_room(events);
  if (first_.size() < first_.capacity()) return;
  exempt([&] { first_.reserve(std::max<std::size_t>(64, 2 * first_.size())); });  // recordings only
}

void KeptMask::packaged(const EventPieces& raw, std::size_t count, EventSpan kept) noexcept {
  if (!is_open_) open_first_ = delivered_.size();
  is_open_ = kept.empty();
  if (!kept.empty()) exempt([&] { first_.push_back(open_first_); });  // it has room
  std::size_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_kept = next < kept.size() && raw[i] == kept[next];
    delivered_.append(is_kept);
    next += is_kept ? 1 : 0;
  }
  is_lost_ = is_lost_ || next < kept.size();
}

std::optional<KeptEvents> KeptMask::read() const {
  if (is_lost_) return std::nullopt;
  KeptEvents reading{.kept = std::vector<std::uint8_t>(passed_.size()), .first = {}};
  reading.first.reserve(first_.size());
  std::size_t passed = 0;
  std::size_t in_ring = 0;
  for (std::size_t i = 0; i < reading.kept.size(); ++i) {
    if (!passed_[i]) continue;
    const bool has_entered = passed < entered_.size() && entered_[passed];
    ++passed;
    if (!has_entered) continue;
    const std::size_t package = reading.first.size();
    if (package < first_.size() && first_[package] == in_ring) {
      reading.first.push_back(static_cast<std::int64_t>(i));
    }
    reading.kept[i] = in_ring < delivered_.size() && delivered_[in_ring] ? 1 : 0;
    ++in_ring;
  }
  return reading;
}

}  // namespace asap::inline v0_1
