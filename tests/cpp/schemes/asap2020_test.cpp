#include "asap/schemes/asap2020.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "core/random.hpp"
#include "support/fake_backlog.hpp"

namespace asap::asap2020_test {
namespace {

using test::FakeBacklog;

// What the scheme takes now, from as many as it wants.
Decision wish(Asap2020& scheme) {
  const FakeBacklog one({0});
  Backlog backlog = one.at(0);
  const Decision decision = scheme.decide(backlog);
  if (decision.takes) return decision;
  backlog.count = decision.until_count;
  return scheme.decide(backlog);
}

// The pull form of the law, in seconds and straight from the formulas; sizes are whole events.
struct Law {
  double a;
  double epsilon;
  double n_max;
  double n_set;
  double gamma = 1;

  void after_package(double n, double processing_s, double span_s) {
    if (span_s > 0 && n >= 2) {
      const double ratio = processing_s / ((1 - epsilon) * span_s);
      n_set = n * std::fmin(std::fmax(ratio, 0.5), 2);
    } else {
      n_set = 2 * n_set;
    }
    n_set = std::fmin(std::fmax(std::floor(n_set), 1), n_max);
    const double rate = n / std::fmax(span_s, 2e-6);
    gamma = rate > a ? std::fmax(0.02, gamma * a / rate) : std::fmin(1, 1.02 * gamma);
  }
};

TEST(Asap2020, FollowsTheLawOverRandomOutcomes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(seed);
    Asap2020 scheme({.rate_bound = 2e6, .epsilon = 0.05, .first_size = 700, .max_size = 20'000});
    Law law{.a = 2e6, .epsilon = 0.05, .n_max = 20'000, .n_set = 700};
    for (std::uint64_t k = 0; k < 500; ++k) {
      const auto size = static_cast<std::size_t>(std::pow(10.0, 4.3 * random.uniform(4 * k)));
      const auto span_ns =
          k % 17 == 0
              ? 0
              : static_cast<std::int64_t>(std::pow(10.0, 3 + 5 * random.uniform(4 * k + 1)));
      const auto processing_ns =
          static_cast<std::int64_t>(std::pow(10.0, 3 + 5 * random.uniform(4 * k + 2)));
      scheme.observe({.size = size,
                      .raw = 2 * size,
                      .span_ns = span_ns,
                      .start_ns = 0,
                      .processing_ns = processing_ns});
      law.after_package(static_cast<double>(size), static_cast<double>(processing_ns) * 1e-9,
                        static_cast<double>(span_ns) * 1e-9);
      const Decision decision = wish(scheme);
      ASSERT_TRUE(decision.takes);
      ASSERT_NEAR(decision.gamma, law.gamma, 1e-9 * law.gamma);
      // Rounding may differ by one kept event, doubled at most once, and 1 / gamma raw ones for
      // each.
      ASSERT_NEAR(static_cast<double>(decision.raw), law.n_set / law.gamma, 1 + 2 / law.gamma)
          << "package " << k;
    }
  }
}

}  // namespace
}  // namespace asap::asap2020_test
