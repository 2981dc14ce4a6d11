// Scheduling noise: a fraction of all atomic operations, wherever they are, first yields, spins or
// sleeps for up to 10 us. In builds with ThreadSanitizer only, whose calls are wrapped by the
// linker.
#pragma once

#include <cstdint>

namespace asap::test {

#if defined(ASAP_NOISE)
// One atomic operation in so many, 0: none. Before the threads start.
void make_noise(std::uint32_t one_in, std::uint64_t seed) noexcept;
// How often there was noise so far.
std::uint64_t noises() noexcept;
#else
inline void make_noise(std::uint32_t, std::uint64_t) noexcept {}
inline std::uint64_t noises() noexcept { return 1; }
#endif

}  // namespace asap::test
