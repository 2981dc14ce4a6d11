// What two threads share. StdAtomics: the atomics of the production build, as the policy of every
// class that a model checker runs; it passes its own: tests/model/relacy. Relaxed: a counter that
// one thread writes and any thread may read meanwhile.
#pragma once

#include <atomic>

namespace asap::inline v0_1 {

struct StdAtomics {
  template <class Value>
  using Atomic = std::atomic<Value>;
};

// A number that one thread writes and any thread may read while it does: the counters of a running
// pipeline. An update is a load and a store, no read-modify-write: as fast as a plain number.
// Numbers read together may be one update apart.
template <class Number>
class Relaxed {
 public:
  Relaxed(Number value = {}) noexcept : value_(value) {}
  Relaxed(const Relaxed& other) noexcept : value_(other.load()) {}
  Relaxed& operator=(const Relaxed& other) noexcept { return *this = other.load(); }
  Relaxed& operator=(Number value) noexcept {
    value_.store(value, std::memory_order_relaxed);
    return *this;
  }

  Relaxed& operator+=(Number more) noexcept { return *this = load() + more; }
  Relaxed& operator++() noexcept { return *this += Number{1}; }

  Number load() const noexcept { return value_.load(std::memory_order_relaxed); }
  operator Number() const noexcept { return load(); }

 private:
  std::atomic<Number> value_;
  static_assert(std::atomic<Number>::is_always_lock_free);
};

// The same of a plain number, which is read as such where nothing writes any more.
template <class Number>
Number load_relaxed(const Number& number) noexcept {
  return std::atomic_ref(const_cast<Number&>(number)).load(std::memory_order_relaxed);
}
template <class Number>
void store_relaxed(Number& number, Number value) noexcept {
  std::atomic_ref(number).store(value, std::memory_order_relaxed);
}

// Orders relaxed accesses. ThreadSanitizer sees no fence, and needs none: it looks for plain
// accesses.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpragmas"
#pragma GCC diagnostic ignored "-Wtsan"
#endif
inline void fence(std::memory_order order) noexcept { std::atomic_thread_fence(order); }
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

}  // namespace asap::inline v0_1
