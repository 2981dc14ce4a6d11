#include "algorithms/newest_patch.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "algorithms/int4.hpp"

namespace asap {
namespace {

using Number = OrderSurface::Number;
constexpr std::ptrdiff_t kReach = 4;
constexpr int kOthers = NewestPatch::kPixels - 1;  // the centre is one of them in any case

// The window without its centre, four numbers at a time: the first eight columns row by row, then
// the ninth. Row 4 has its eight pixels beside the centre. (The centre was written just now: a load
// across it would wait for the store.)
class Window {
 public:
  Window(const Number* centre, std::ptrdiff_t stride) noexcept {
    const Number* row = centre - kReach * stride - kReach;
    Number ninth[kSide];
    for (std::size_t y = 0; y < kSide; ++y, row += stride) {
      parts_[2 * y] = Int4::load(row);
      parts_[2 * y + 1] = Int4::load(y == kReach ? row + 5 : row + 4);
      ninth[y] = row[8];
    }
    parts_[18] = Int4::of(ninth[0], ninth[1], ninth[2], ninth[3]);
    parts_[19] = Int4::of(ninth[5], ninth[6], ninth[7], ninth[8]);
  }

  // Numbers that reach the bar. Two sums, so that they do not wait for each other.
  int count(Number bar) const noexcept {
    Int4::Lanes counts[2]{Int4::zero(), Int4::zero()};
    for (std::size_t i = 0; i < 20; i += 2) {
      for (std::size_t j = 0; j < 2; ++j) {
        counts[j] = Int4::count_above(counts[j], parts_[i + j], bar - 1);
      }
    }
    return Int4::sum(Int4::add(counts[0], counts[1]));
  }

  void rows(Number bar, PatchRows& rows) const noexcept {
    const auto mask = [&](std::size_t part) { return Int4::mask_above(parts_[part], bar - 1); };
    const std::uint32_t ninth = mask(18) | mask(19) << 5;
    for (std::size_t y = 0; y < kSide; ++y) {
      rows[y] = mask(2 * y) | mask(2 * y + 1) << 4 | ((ninth >> y) & 1) << 8;
    }
    rows[kReach] = mask(2 * kReach) | 1U << 4 | mask(2 * kReach + 1) << 5;
  }

 private:
  static constexpr std::size_t kSide = 9;

  Int4::Lanes parts_[20];
};

}  // namespace

NewestPatch::NewestPatch(Path path) noexcept : avx2_(path == Path::fastest && has_avx2()) {}

bool NewestPatch::select(const Number* centre, std::ptrdiff_t stride, PatchRows& rows) noexcept {
  if (avx2_) {
    const PatchSearch result = select_avx2(centre, stride, depth_, rows);
    if (result != PatchSearch::unresolved) return result == PatchSearch::found;
  }
  return search(centre, stride, rows);
}

bool NewestPatch::search(const Number* centre, std::ptrdiff_t stride, PatchRows& rows) noexcept {
  constexpr Number kLowest = OrderSurface::kNever + 1;
  const Window window(centre, stride);
  const Number newest = *centre;

  // Down to a bar that enough numbers reach, by steps as large as the way so far.
  Number high = newest;
  Number bar = newest - depth_ > kLowest ? newest - depth_ : kLowest;
  int above = window.count(bar);
  while (above < kOthers) {
    if (bar == kLowest) return false;
    high = bar;
    const Number depth = newest - bar;
    bar = depth < bar - kLowest ? bar - depth : kLowest;
    above = window.count(bar);
  }
  // More than 24 others reach `low`, fewer reach `high`.
  for (Number low = bar; above != kOthers;) {
    bar = low + (high - low) / 2;
    above = window.count(bar);
    high = above < kOthers ? bar : high;
    low = above < kOthers ? low : bar;
  }
  depth_ = newest - bar;
  window.rows(bar, rows);
  return true;
}

// ---- select_avx2 ----

#if defined(__x86_64__)

// Applies to single functions: the rest of the library runs on every machine.
#define ASAP_AVX2 __attribute__((target("avx2")))

namespace {

constexpr int kMaxStep = 13;  // log2: three such steps are 24576

struct Counts {
  int first;
  int second;
  int third;
};

// Ages, newest number minus number, divided by 2^shift, of all pixels but the centre: two rows of
// eight columns per register; the last one holds row 4 and the ninth column.
struct Ages {
  __m256i pairs[5];
};

ASAP_AVX2 inline __m256i load8(const Number* from) noexcept {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}

ASAP_AVX2 inline Ages ages_around(const Number* centre, std::ptrdiff_t stride, int shift) noexcept {
  const __m256i newest = _mm256_set1_epi32(*centre);
  const __m128i bits = _mm_cvtsi32_si128(shift);
  const Number* top = centre - 4 * stride - 4;
  const auto row = [&](int y) { return top + y * stride; };
  const auto ninth = [&](int y) { return row(y)[8]; };
  const __m256i column = _mm256_setr_epi32(ninth(0), ninth(1), ninth(2), ninth(3), ninth(5),
                                           ninth(6), ninth(7), ninth(8));
  const __m256i middle = _mm256_loadu2_m128i(reinterpret_cast<const __m128i*>(row(4) + 5),
                                             reinterpret_cast<const __m128i*>(row(4)));
  const __m256i parts[10] = {load8(row(0)), load8(row(1)), load8(row(2)), load8(row(3)),
                             load8(row(5)), load8(row(6)), load8(row(7)), load8(row(8)),
                             middle,        column};
  Ages ages;
  for (int i = 0; i < 5; ++i) {
    const __m256i a = _mm256_sra_epi32(_mm256_sub_epi32(newest, parts[2 * i]), bits);
    const __m256i b = _mm256_sra_epi32(_mm256_sub_epi32(newest, parts[2 * i + 1]), bits);
    ages.pairs[i] = _mm256_packs_epi32(a, b);
  }
  return ages;
}

ASAP_AVX2 inline __m256i repeated(int number) noexcept {
  return _mm256_set1_epi16(static_cast<std::int16_t>(number));
}

// The sums of bytes of the lower and the upper eight bytes of both halves.
ASAP_AVX2 inline __m128i byte_sums(__m256i bytes) noexcept {
  const __m256i sums = _mm256_sad_epu8(bytes, _mm256_setzero_si256());
  return _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
}

// How many ages are below low + step, low + 2 step, low + 3 step.
ASAP_AVX2 inline Counts count_below(const Ages& ages, int low, int step) noexcept {
  const __m256i bars[3] = {repeated(low + step), repeated(low + 2 * step),
                           repeated(low + 3 * step)};
  const __m256i zero = _mm256_setzero_si256();
  __m256i sums[3] = {zero, zero, zero};
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 3; ++j) {
      sums[j] = _mm256_sub_epi16(sums[j], _mm256_cmpgt_epi16(bars[j], ages.pairs[i]));
    }
  }
  const __m128i two = byte_sums(_mm256_packus_epi16(sums[0], sums[1]));
  const __m128i one = byte_sums(_mm256_packus_epi16(sums[2], zero));
  return {_mm_cvtsi128_si32(two), _mm_extract_epi16(two, 4), _mm_cvtsi128_si32(one)};
}

// Bit for byte, of the ages below the bar in two registers.
ASAP_AVX2 inline std::uint32_t mask_below(__m256i bar, __m256i a, __m256i b) noexcept {
  const __m256i below = _mm256_packs_epi16(_mm256_cmpgt_epi16(bar, a), _mm256_cmpgt_epi16(bar, b));
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(below));
}

// Row i of four in a mask: four bits at 4 i, the next four 16 bits above.
constexpr std::uint32_t row_of(std::uint32_t mask, int i) noexcept {
  const std::uint32_t bits = mask >> (4 * i);
  return (bits & 0xf) | ((bits >> 12) & 0xf0);
}

// Row 4 of its pixels beside the centre.
constexpr std::uint32_t with_centre(std::uint32_t others) noexcept {
  return (others & 0xf) | 1U << 4 | (others & 0xf0) << 1;
}

ASAP_AVX2 inline void rows_below(const Ages& ages, int bar, PatchRows& rows) noexcept {
  const __m256i bars = repeated(bar);
  const std::uint32_t upper = mask_below(bars, ages.pairs[0], ages.pairs[1]);
  const std::uint32_t lower = mask_below(bars, ages.pairs[2], ages.pairs[3]);
  const std::uint32_t middle = mask_below(bars, ages.pairs[4], ages.pairs[4]);
  const std::uint32_t column = row_of(middle, 1);
  for (int i = 0; i < 4; ++i) {
    const auto y = static_cast<std::size_t>(i);
    rows[y] = row_of(upper, i) | ((column >> i) & 1) << 8;
    rows[y + 5] = row_of(lower, i) | ((column >> (i + 4)) & 1) << 8;
  }
  rows[4] = with_centre(row_of(middle, 0));
}

// Pixels of the window that have fired, the centre included.
ASAP_AVX2 int fired_around(const Number* centre, std::ptrdiff_t stride) noexcept {
  const __m256i never = _mm256_set1_epi32(OrderSurface::kNever);
  __m256i sums = _mm256_setzero_si256();
  int fired = 0;
  const Number* row = centre - 4 * stride - 4;
  for (int y = 0; y < 9; ++y, row += stride) {
    sums = _mm256_sub_epi32(sums, _mm256_cmpgt_epi32(load8(row), never));
    fired += row[8] > OrderSurface::kNever;
  }
  const __m128i halves = byte_sums(sums);
  return fired + _mm_cvtsi128_si32(halves) + _mm_extract_epi16(halves, 4);
}

}  // namespace

bool has_avx2() noexcept {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2");
}

ASAP_AVX2 PatchSearch select_avx2(const Number* centre, std::ptrdiff_t stride, Number& depth,
                                  PatchRows& rows) noexcept {
  const auto given_up = [&] {
    return fired_around(centre, stride) < NewestPatch::kPixels ? PatchSearch::too_few
                                                               : PatchSearch::unresolved;
  };
  const auto bits_of = [](Number n) {
    return static_cast<int>(std::bit_width(static_cast<std::uint32_t>(n)));
  };
  const int shift = std::max(0, bits_of(depth) - kMaxStep);
  const Ages ages = ages_around(centre, stride, shift);

  // Steps so large that three of them hold enough pixels.
  int step = std::clamp(bits_of(depth >> shift) - 1, 0, kMaxStep);
  Counts counts = count_below(ages, 0, 1 << step);
  while (counts.third < kOthers) {
    if (step == kMaxStep) return given_up();
    step = std::min(step + 2, kMaxStep);
    counts = count_below(ages, 0, 1 << step);
  }
  // Then a quarter as large, from the last bar that too few pixels reach.
  int low = 0;
  while (true) {
    const auto [first, second, third] = counts;
    low += ((first < kOthers) + (second < kOthers) + (third < kOthers)) << step;
    if (first == kOthers || second == kOthers || third == kOthers) break;
    if (step == 0) return given_up();
    step = std::max(step - 2, 0);
    counts = count_below(ages, low, 1 << step);
  }
  const int bar = low + (1 << step);

  // No pixel among them never fired: those are all of one age, so the count would be 80.
  depth = bar << shift;
  rows_below(ages, bar, rows);
  return PatchSearch::found;
}

#undef ASAP_AVX2

#else

bool has_avx2() noexcept { return false; }

PatchSearch select_avx2(const OrderSurface::Number*, std::ptrdiff_t, OrderSurface::Number&,
                        PatchRows&) noexcept {
  return PatchSearch::unresolved;
}

#endif

}  // namespace asap
