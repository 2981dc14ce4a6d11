#include "study/rival.hpp"

#include <gtest/gtest.h>

#include "support/errors.hpp"

namespace asap::rival_test {
namespace {

class Own final : public Rival {
 public:
  using Rival::Rival;
  Decision decide(const Backlog& backlog) noexcept override {
    return Decision::take(backlog.count);
  }
  std::string_view name() const noexcept override { return "own"; }
};

TEST(Rival, HasALatencyBoundThatStays) {
  Own own(7.5);
  EXPECT_EQ(own.parameters(), (SchemeParameters{{"latency_ms", 7.5}}));
  EXPECT_EQ(own.latency_bound_ns(), 7'500'000);
  own.set_latency_bound_ns(1'000'000);
  EXPECT_EQ(own.latency_bound_ns(), 7'500'000);
}

TEST(Rival, RefusesABoundOutOfRange) {
  EXPECT_EQ(test::error_of([] { Own bad(-1); }),
            "latency_ms = -1: must be between 0.01 and 1e7 ms");
}

}  // namespace
}  // namespace asap::rival_test
