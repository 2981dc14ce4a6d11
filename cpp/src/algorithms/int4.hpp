// Int4: four 32-bit integers at a time, for the inner loops of filters and corner detectors: SSE2,
// which every x86-64 has, or loops with the same results. Pure functions. ASAP_PORTABLE asks for
// the loops on x86-64 too.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace asap::inline v0_1 {

struct PortableInt4 {
  using Lanes = std::array<std::int32_t, 4>;

  static Lanes of(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) noexcept {
    return {a, b, c, d};
  }
  static Lanes zero() noexcept { return {}; }

  static Lanes load(const std::int32_t* from) noexcept {
    return {from[0], from[1], from[2], from[3]};
  }
  static void store(const Lanes& lanes, std::int32_t* to) noexcept {
    std::copy(lanes.begin(), lanes.end(), to);
  }

  static Lanes max(Lanes a, const Lanes& b) noexcept {
    for (std::size_t i = 0; i < 4; ++i) a[i] = std::max(a[i], b[i]);
    return a;
  }
  static std::int32_t largest(const Lanes& lanes) noexcept {
    return std::max(std::max(lanes[0], lanes[1]), std::max(lanes[2], lanes[3]));
  }

  // Bit i: lane i > bar.
  static std::uint32_t mask_above(const Lanes& lanes, std::int32_t bar) noexcept {
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < 4; ++i) mask |= static_cast<std::uint32_t>(lanes[i] > bar) << i;
    return mask;
  }

  // Bit i: lanes i of a and b lie before the time, modulo 2^32.
  static std::uint32_t mask_before(const Lanes& a, const Lanes& b, std::int32_t time) noexcept {
    const auto since = [&](std::int32_t lane) {
      return static_cast<std::uint32_t>(lane) - static_cast<std::uint32_t>(time);
    };
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < 4; ++i) mask |= (since(a[i]) & since(b[i])) >> 31 << i;
    return mask;
  }

  // `counts`, and one more in each lane above the bar.
  static Lanes count_above(Lanes counts, const Lanes& lanes, std::int32_t bar) noexcept {
    for (std::size_t i = 0; i < 4; ++i) counts[i] += lanes[i] > bar;
    return counts;
  }
  static Lanes add(Lanes a, const Lanes& b) noexcept {
    for (std::size_t i = 0; i < 4; ++i) a[i] += b[i];
    return a;
  }
  static std::int32_t sum(const Lanes& lanes) noexcept {
    return lanes[0] + lanes[1] + lanes[2] + lanes[3];
  }
};

#if defined(__SSE2__)

struct Sse2Int4 {
  using Lanes = __m128i;

  static Lanes of(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) noexcept {
    return _mm_setr_epi32(a, b, c, d);
  }
  static Lanes zero() noexcept { return _mm_setzero_si128(); }

  static Lanes load(const std::int32_t* from) noexcept {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  }
  static void store(Lanes lanes, std::int32_t* to) noexcept {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), lanes);
  }

  static Lanes max(Lanes a, Lanes b) noexcept {
    const __m128i greater = _mm_cmpgt_epi32(a, b);
    return _mm_or_si128(_mm_and_si128(greater, a), _mm_andnot_si128(greater, b));
  }
  static std::int32_t largest(Lanes lanes) noexcept {
    lanes = max(lanes, swapped_pairs(lanes));
    return _mm_cvtsi128_si32(max(lanes, swapped_neighbours(lanes)));
  }

  static std::uint32_t mask_above(Lanes lanes, std::int32_t bar) noexcept {
    const __m128i above = _mm_cmpgt_epi32(lanes, _mm_set1_epi32(bar));
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_castsi128_ps(above)));
  }

  static std::uint32_t mask_before(Lanes a, Lanes b, std::int32_t time) noexcept {
    const __m128i start = _mm_set1_epi32(time);
    const __m128i since = _mm_and_si128(_mm_sub_epi32(a, start), _mm_sub_epi32(b, start));
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_castsi128_ps(since)));
  }

  static Lanes count_above(Lanes counts, Lanes lanes, std::int32_t bar) noexcept {
    return _mm_sub_epi32(counts, _mm_cmpgt_epi32(lanes, _mm_set1_epi32(bar)));
  }
  static Lanes add(Lanes a, Lanes b) noexcept { return _mm_add_epi32(a, b); }
  static std::int32_t sum(Lanes lanes) noexcept {
    lanes = _mm_add_epi32(lanes, swapped_pairs(lanes));
    return _mm_cvtsi128_si32(_mm_add_epi32(lanes, swapped_neighbours(lanes)));
  }

 private:
  static Lanes swapped_pairs(Lanes lanes) noexcept {
    return _mm_shuffle_epi32(lanes, _MM_SHUFFLE(1, 0, 3, 2));
  }
  static Lanes swapped_neighbours(Lanes lanes) noexcept {
    return _mm_shuffle_epi32(lanes, _MM_SHUFFLE(2, 3, 0, 1));
  }
};

#endif

#if defined(__SSE2__) && !defined(ASAP_PORTABLE)
using Int4 = Sse2Int4;
#else
using Int4 = PortableInt4;
#endif

}  // namespace asap::inline v0_1
