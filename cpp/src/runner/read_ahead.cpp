#include "runner/read_ahead.hpp"

#include <algorithm>

namespace asap::inline v0_1 {

ReadAhead::ReadAhead() : blocks_(kBlocks) {
  for (Block& block : blocks_) block.events = std::make_unique_for_overwrite<Event[]>(kBlockEvents);
}

bool ReadAhead::feed(EventSpan events) {
  while (!events.empty()) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return cancelled_ || filled_ - released_ < kBlocks; });
      if (cancelled_) return false;
    }
    Block& block = blocks_[filled_ % kBlocks];  // free: only the reader touches it
    block.size = std::min(events.size(), kBlockEvents);
    std::copy_n(events.data(), block.size, block.events.get());
    events = events.subspan(block.size);
    {
      const std::lock_guard lock(mutex_);
      ++filled_;
    }
    changed_.notify_all();
  }
  return true;
}

void ReadAhead::finish() noexcept {
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
  }
  changed_.notify_all();
}

EventSpan ReadAhead::next() {
  std::unique_lock lock(mutex_);
  released_ = taken_;
  changed_.notify_all();
  changed_.wait(lock, [this] { return cancelled_ || finished_ || taken_ < filled_; });
  if (cancelled_ || taken_ == filled_) return {};
  const Block& block = blocks_[taken_ % kBlocks];
  ++taken_;
  return {block.events.get(), block.size};
}

void ReadAhead::cancel() noexcept {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  changed_.notify_all();
}

}  // namespace asap::inline v0_1
