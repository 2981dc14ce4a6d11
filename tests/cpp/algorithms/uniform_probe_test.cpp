#include "algorithms/uniform_probe.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

namespace uniform_probe_test {
namespace {

using asap::ProbeDraw;
using asap::UniformProbe;

std::vector<std::uint64_t> draw(UniformProbe& probe, std::uint64_t count, int times) {
  std::vector<std::uint64_t> draws;
  for (int i = 0; i < times; ++i) {
    draws.push_back(probe(ProbeDraw{}, count, [](std::uint64_t member) { return member; }));
  }
  return draws;
}

TEST(UniformProbe, DrawsEveryMemberEquallyOften) {
  constexpr std::uint64_t kCount = 17;
  constexpr int kTimes = 170'000;
  UniformProbe probe(42);
  std::array<int, kCount> hits{};
  for (const auto member : draw(probe, kCount, kTimes)) {
    ASSERT_LT(member, kCount);
    ++hits[member];
  }
  double chi_square = 0;
  for (const int h : hits) chi_square += (h - 10'000.0) * (h - 10'000.0) / 10'000.0;
  EXPECT_LT(chi_square, 39.3);  // 99.9 % of chi-square with 16 degrees of freedom
}

TEST(UniformProbe, SameSeedSameDraws) {
  UniformProbe a(7);
  UniformProbe b(7);
  UniformProbe other(8);
  const auto first = draw(a, 1000, 100);
  EXPECT_EQ(draw(b, 1000, 100), first);
  EXPECT_NE(draw(other, 1000, 100), first);
  EXPECT_NE(draw(a, 1000, 100), first);
  a.clear();
  EXPECT_EQ(draw(a, 1000, 100), first);
}

// Pinned: the same on every compiler and platform.
TEST(UniformProbe, FirstDraws) {
  UniformProbe probe(0);
  EXPECT_EQ(draw(probe, 800, 6), (std::vector<std::uint64_t>{225, 521, 560, 309, 525, 630}));
}

}  // namespace
}  // namespace uniform_probe_test
