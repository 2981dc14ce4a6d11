#include "noise.hpp"

#include <sched.h>
#include <time.h>

#include <atomic>
#include <cstdint>

namespace {

std::uint32_t noise_one_in = 0;
std::uint64_t noise_seed = 0;
std::atomic<std::uint64_t> made{0};
std::atomic<std::uint64_t> threads{0};
thread_local std::uint64_t state = 0;

std::uint64_t draw() noexcept {  // xorshift64
  if (state == 0) state = (noise_seed + ++threads) * 0x9E3779B97F4A7C15u | 1u;
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return state;
}

std::int64_t now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

void noise() noexcept {
  if (noise_one_in == 0 || draw() % noise_one_in != 0) return;
  made.fetch_add(1, std::memory_order_relaxed);
  const auto length_ns = static_cast<std::int64_t>(draw() % 10'000);
  switch (draw() % 4) {
    case 0: {
      const timespec length{0, length_ns};
      nanosleep(&length, nullptr);
      break;
    }
    case 1: {
      const std::int64_t end_ns = now_ns() + length_ns;
      while (now_ns() < end_ns) {
      }
      break;
    }
    default:
      sched_yield();
  }
}

}  // namespace

void asap::test::make_noise(std::uint32_t one_in, std::uint64_t seed) noexcept {
  noise_one_in = one_in;
  noise_seed = seed;
}

std::uint64_t asap::test::noises() noexcept { return made.load(std::memory_order_relaxed); }

// The linker leads every call of __tsan_atomic... here (--wrap).
#define ASAP_NOISY_RMW(Value, bits, name)                                                 \
  Value __real___tsan_atomic##bits##_##name(volatile Value* at, Value value, int order);  \
  Value __wrap___tsan_atomic##bits##_##name(volatile Value* at, Value value, int order) { \
    noise();                                                                              \
    return __real___tsan_atomic##bits##_##name(at, value, order);                         \
  }
#define ASAP_NOISY_CAS(Value, bits)                                                              \
  int __real___tsan_atomic##bits##_compare_exchange_strong(volatile Value* at, Value* expected,  \
                                                           Value value, int order, int failed);  \
  int __wrap___tsan_atomic##bits##_compare_exchange_strong(volatile Value* at, Value* expected,  \
                                                           Value value, int order, int failed) { \
    noise();                                                                                     \
    return __real___tsan_atomic##bits##_compare_exchange_strong(at, expected, value, order,      \
                                                                failed);                         \
  }
#define ASAP_NOISY(Value, bits)                                                         \
  Value __real___tsan_atomic##bits##_load(const volatile Value* at, int order);         \
  Value __wrap___tsan_atomic##bits##_load(const volatile Value* at, int order) {        \
    noise();                                                                            \
    return __real___tsan_atomic##bits##_load(at, order);                                \
  }                                                                                     \
  void __real___tsan_atomic##bits##_store(volatile Value* at, Value value, int order);  \
  void __wrap___tsan_atomic##bits##_store(volatile Value* at, Value value, int order) { \
    noise();                                                                            \
    __real___tsan_atomic##bits##_store(at, value, order);                               \
  }                                                                                     \
  ASAP_NOISY_CAS(Value, bits)                                                           \
  ASAP_NOISY_RMW(Value, bits, exchange)                                                 \
  ASAP_NOISY_RMW(Value, bits, fetch_add)                                                \
  ASAP_NOISY_RMW(Value, bits, fetch_or)                                                 \
  ASAP_NOISY_RMW(Value, bits, fetch_and)

extern "C" {
ASAP_NOISY(std::int8_t, 8)
ASAP_NOISY(std::int32_t, 32)
ASAP_NOISY(std::int64_t, 64)
}
