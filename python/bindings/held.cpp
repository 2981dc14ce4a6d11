#include "held.hpp"

#include "gil.hpp"

namespace asap::python {

bool Turns::try_lock() noexcept {
  std::uint32_t own = serving_.load(std::memory_order_acquire);
  if (!next_.compare_exchange_strong(own, own + 1, std::memory_order_acquire)) return false;
  owner_ = std::this_thread::get_id();
  return true;
}

void Turns::lock() noexcept {
  const std::uint32_t own = next_.fetch_add(1, std::memory_order_relaxed);
  for (;;) {
    const std::uint32_t now = serving_.load(std::memory_order_acquire);
    if (now == own) break;
    serving_.wait(now, std::memory_order_acquire);
  }
  owner_ = std::this_thread::get_id();
}

void Turns::unlock() noexcept {
  owner_ = std::thread::id();
  serving_.fetch_add(1, std::memory_order_release);
  serving_.notify_all();
}

CallersTurn::CallersTurn(Turns& turns) {
  if (turns.are_mine()) return;
  if (!turns.try_lock()) {
    if (is_exiting()) return;
    const WithoutGil release;  // the other thread may need it to come to its end
    turns.lock();
  }
  turns_ = &turns;
}

CallersTurn::~CallersTurn() {
  if (turns_ != nullptr) turns_->unlock();
}

}  // namespace asap::python
