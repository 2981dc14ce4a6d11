#include "algorithms/int4.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>

#include "core/random.hpp"

namespace int4_test {
namespace {

using asap::PortableInt4;

constexpr std::int32_t kLow = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kHigh = std::numeric_limits<std::int32_t>::max();

// All that the type in use says about two rows of numbers and a bar.
template <class Int4>
std::array<std::int64_t, 12> answers(const std::array<std::int32_t, 8>& numbers, std::int32_t bar) {
  const auto a = Int4::load(&numbers[0]);
  const auto b = Int4::of(numbers[4], numbers[5], numbers[6], numbers[7]);
  std::array<std::int32_t, 4> larger;
  Int4::store(Int4::max(a, b), larger.data());
  std::array<std::int32_t, 4> counts;
  const auto first = Int4::count_above(Int4::zero(), a, bar);
  Int4::store(Int4::add(first, Int4::count_above(first, b, bar)), counts.data());
  return {larger[0],
          larger[1],
          larger[2],
          larger[3],
          counts[0],
          counts[1],
          counts[2],
          counts[3],
          Int4::largest(a),
          Int4::mask_above(b, bar),
          Int4::mask_before(a, b, bar),
          Int4::sum(Int4::count_above(Int4::zero(), a, bar))};
}

TEST(Int4, TheTypeInUseAnswersAsThePortableOne) {
  const asap::CounterRandom random(1);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const auto draw = [&](std::uint64_t j) -> std::int32_t {
      const std::uint64_t bits = random(10 * i + j);
      const std::array<std::int32_t, 5> special{kLow, kHigh, 0, -1, 1};
      return bits % 3 == 0 ? special[(bits >> 8) % 5] : static_cast<std::int32_t>(bits >> 32);
    };
    std::array<std::int32_t, 8> numbers;
    for (std::size_t j = 0; j < 8; ++j) numbers[j] = draw(j);
    const std::int32_t bar = i % 2 == 0 ? draw(8) : numbers[i % 8];
    ASSERT_EQ(answers<asap::Int4>(numbers, bar), answers<PortableInt4>(numbers, bar));
  }
}

}  // namespace
}  // namespace int4_test
