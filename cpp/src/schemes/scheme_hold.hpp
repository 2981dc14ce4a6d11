// SchemeHold: what a run in real time holds of its scheme while it resets or asks it, so that no
// other run does meanwhile. One thread at a time calls take() and release(); two holds of one
// scheme may meet on two threads.
#pragma once

#include <atomic>
#include <stdexcept>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

class SchemeHold {
 public:
  explicit SchemeHold(Scheme& scheme) : scheme_(scheme) { take(); }
  ~SchemeHold() { release(); }
  SchemeHold(const SchemeHold&) = delete;
  SchemeHold& operator=(const SchemeHold&) = delete;

  // Nothing, if it is held already. Throws std::logic_error while another run has the scheme.
  void take() {
    if (is_held_) return;
    if (scheme_.in_use_.flag.exchange(true, std::memory_order_acq_rel)) {
      throw std::logic_error("scheme: serves another run; end that one, or give a scheme to each");
    }
    is_held_ = true;
  }
  void release() noexcept {
    if (is_held_) scheme_.in_use_.flag.store(false, std::memory_order_release);
    is_held_ = false;
  }

 private:
  Scheme& scheme_;
  bool is_held_ = false;
};

}  // namespace asap::inline v0_1
