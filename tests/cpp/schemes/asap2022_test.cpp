#include "asap/schemes/asap2022.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>

#include "core/random.hpp"
#include "support/fake_backlog.hpp"

namespace asap::asap2022_test {
namespace {

using namespace std::chrono_literals;

using test::FakeBacklog;

constexpr std::int64_t kMillisecond = 1'000'000;

// What the scheme takes from very many events that wait from oldest_ns to now_ns.
Decision wish(Asap2022& scheme, std::int64_t oldest_ns = 0, std::int64_t now_ns = 0) {
  const FakeBacklog one({oldest_ns});
  Backlog backlog = one.at(now_ns);
  backlog.count = 100'000'000;
  return scheme.decide(backlog);
}

// The package that was taken was this large and took that long.
void observe(Asap2022& scheme, std::size_t size, std::int64_t processing_ns) {
  scheme.observe(
      {.size = size, .raw = size, .span_ns = 0, .start_ns = 0, .processing_ns = processing_ns});
}

std::size_t size_after(Asap2022& scheme, std::int64_t processing_ns) {
  observe(scheme, 1, processing_ns);
  return wish(scheme).raw;
}

TEST(Asap2022, TheSizeIsAnArcTangentOfTheLogarithmOfMilliseconds) {
  Asap2022 scheme;
  EXPECT_EQ(wish(scheme).raw, 1000u);
  EXPECT_EQ(size_after(scheme, 200'000), 100u);
  EXPECT_EQ(size_after(scheme, 1), 100u);
  EXPECT_EQ(size_after(scheme, -5), 100u);
  // S = 29600 / (atan(ln 10) - atan(ln 0.2)), and where the logarithm is 0: 29700 - S atan(ln 10).
  EXPECT_EQ(size_after(scheme, 1 * kMillisecond), 13'905u);
  Asap2022 steep({.min_processing = 500us, .max_processing = 2ms, .kappa = 5});
  EXPECT_EQ(size_after(steep, 1 * kMillisecond), 14'900u);  // halfway, by symmetry
}

// notebooks/theory.md, 12 (2): 100 us + 300 ns per event.
TEST(Asap2022, TheSizeDependsOnTheStart) {
  const auto end_from = [](std::size_t first_size) {
    Asap2022 scheme({.min_gamma = 1.0, .first_size = first_size});
    std::size_t size = wish(scheme).raw;
    for (int k = 0; k < 100; ++k) {
      size = size_after(scheme, static_cast<std::int64_t>(100'000 + 300 * size));
    }
    return size;
  };
  EXPECT_EQ(end_from(100), 100u);
  EXPECT_EQ(end_from(300), 100u);
  EXPECT_EQ(end_from(1000), 29'446u);
  EXPECT_EQ(end_from(29'700), 29'446u);
}

// The law as a node would carry it out, event by event, gammas and rates in seconds.
class Law {
 public:
  explicit Law(double g_min, double g_max) : g_min_(g_min), g_max_(g_max) {}

  void feed_back(double t_ms) {
    const double t = std::fmin(std::fmax(t_ms, 0.2), 10.0);
    g_top_ = g_max_ - (t - 0.2) / 9.8 * (g_max_ - g_min_);
    const auto phi = [](double x) { return std::atan(std::log(x)); };
    const double s = 29'600 / (phi(10) - phi(0.2));
    size = std::round(std::fmin(std::fmax(s * phi(t) + 29'700 - s * phi(10), 100), 29'700));
  }

  void event(std::int64_t time_ns) {
    if (begin_ns_ < 0) begin_ns_ = time_ns;
    while (time_ns >= begin_ns_ + 20 * kMillisecond) {
      begin_ns_ += 20 * kMillisecond;
      if (held > 0) container(begin_ns_);
      held = 0;
    }
    if (++held < 1000) return;
    held = 0;
    begin_ns_ = time_ns;
    container(time_ns);
  }

  // Raw events that keep `size`, in steps of one event.
  double raw() const {
    double kept = 0;
    double raw = 0;
    for (int i = held; i < 1000 && kept < size; ++i, ++raw) kept += gamma;
    return kept < size ? raw + (size - kept) / std::fmax(mean_gamma, 0.02) : raw;
  }

  double size = 1000;
  double gamma = 1;
  double mean_gamma = 1;
  int held = 0;

 private:
  void container(std::int64_t time_ns) {
    times_ns_.push_back(time_ns);
    if (times_ns_.size() <= 500) return;
    times_ns_.pop_front();
    const double window_s = static_cast<double>(times_ns_.back() - times_ns_.front()) * 1e-9;
    const double r = 500 / std::fmax(window_s, 1e-6);
    r_max_ = r > r_max_ ? r : 0.99 * r_max_;
    r_min_ = r < r_min_ ? r : r_min_ / 0.99;
    gamma =
        r_max_ == r_min_ ? g_top_ : g_top_ - (r - r_min_) / (r_max_ - r_min_) * (g_top_ - g_min_);
    gamma = std::fmin(std::fmax(gamma, 0), 1);
    mean_gamma += (gamma - mean_gamma) / 16;
  }

  double g_min_;
  double g_max_;
  double g_top_ = 1;
  double r_max_ = 5e5;
  double r_min_ = 5e5;
  std::int64_t begin_ns_ = -1;
  std::deque<std::int64_t> times_ns_;
};

TEST(Asap2022, FollowsTheLawOverRandomStreams) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const CounterRandom random(seed);
    const double g_min = seed % 2 == 0 ? 0.1 : 0.4;
    Asap2022 scheme({.min_gamma = g_min});
    Law law(g_min, 1.0);
    std::int64_t oldest_ns = 0;
    double min = 1;
    std::size_t containers = 0;
    for (std::uint64_t k = 0; containers < 3000; ++k) {
      const std::int64_t step_ns = static_cast<std::int64_t>(60 + random(3 * k) % 2000);
      const Decision decision = wish(scheme, oldest_ns, std::numeric_limits<std::int64_t>::max());
      ASSERT_TRUE(decision.takes);
      const auto raw = static_cast<double>(decision.raw);
      ASSERT_NEAR(raw, law.raw(), 1 + 1e-6 * raw) << "package " << k;
      ASSERT_NEAR(decision.gamma * raw, law.size, 1 + 1e-6 * raw) << "package " << k;
      min = std::fmin(min, decision.gamma);
      const auto processing_ns =
          static_cast<std::int64_t>(std::pow(10.0, 5 + 0.7 * random.uniform(3 * k + 1)));
      scheme.observe({.size = decision.raw / 2,
                      .raw = decision.raw,
                      .span_ns = 0,
                      .start_ns = 0,
                      .processing_ns = processing_ns});
      law.feed_back(static_cast<double>(processing_ns) * 1e-6);
      // Where the events of the package lay is known afterwards.
      for (std::size_t i = 0; i < decision.raw; ++i) {
        law.event(oldest_ns + static_cast<std::int64_t>(i) * step_ns);
      }
      oldest_ns += static_cast<std::int64_t>(decision.raw) * step_ns;
      containers += 1 + decision.raw / 1000;
    }
    EXPECT_LT(min, 0.8) << "gamma never acted";
  }
}

// A stream of `rate` with a jitter of the containers' times; the fraction that is kept of it.
double kept_at(double rate, std::size_t size, double seconds) {
  const CounterRandom random(7);
  Asap2022 scheme({.min_size = size, .first_size = size});
  double now_s = 0;
  double raw = 0;
  double kept = 0;
  for (std::uint64_t k = 0; now_s < seconds; ++k) {
    const auto now_ns = static_cast<std::int64_t>(now_s * 1e9);
    const Decision decision = wish(scheme, now_ns, std::numeric_limits<std::int64_t>::max());
    const auto taken = static_cast<double>(decision.raw);
    if (now_s > 0.3 * seconds) {
      raw += taken;
      kept += taken * decision.gamma;
    }
    now_s += taken / rate * (0.9 + 0.2 * random.uniform(k));
    observe(scheme, decision.raw, 1);  // the fastest algorithm: size min_size, gamma up to 1
  }
  return kept / raw;
}

// notebooks/theory.md, 12 (3): r_min and r_max cross again and again; 0.70 on average, at any rate.
TEST(Asap2022, GammaChattersAtAConstantRate) {
  for (const double rate : {1e5, 1e6, 5e6, 2e7}) {
    const double seconds = 5e6 / rate;  // 5000 containers
    EXPECT_NEAR(kept_at(rate, 100, seconds), 0.70, 0.03) << rate;
    EXPECT_NEAR(kept_at(rate, 5000, seconds), 0.70, 0.08) << rate;
  }
}

// notebooks/theory.md, 12 (5): without feedback the node's gamma was 0, later NaN for good.
TEST(Asap2022, NoFeedbackDoesNotLockIt) {
  Asap2022 scheme;
  std::int64_t now_ns = 0;
  double kept = 0;
  for (int k = 0; k < 3000; ++k) {
    const Decision decision = wish(scheme, now_ns, now_ns + kMillisecond);
    kept += decision.gamma;
    scheme.observe({.size = 0, .raw = 1000, .span_ns = 0, .start_ns = now_ns, .processing_ns = 0});
    now_ns += kMillisecond;
  }
  EXPECT_GT(kept, 1500.0);
  const Decision decision = wish(scheme, now_ns, now_ns);
  EXPECT_NEAR(static_cast<double>(decision.raw) * decision.gamma, 1000.0, 1.0);
}

// 501 containers on one stamp would make r infinite, and gamma NaN for good.
TEST(Asap2022, AFloodOnOneStampPasses) {
  Asap2022 scheme;
  const auto take = [&](std::int64_t now_ns) {
    const Decision decision = wish(scheme, now_ns, now_ns);
    observe(scheme, decision.raw, 1);
    return decision.gamma;
  };
  for (int k = 0; k < 20'000; ++k) {
    const double gamma = take(0);
    ASSERT_GE(gamma, 0.0);
    ASSERT_LE(gamma, 1.0);
  }
  double kept = 0;
  for (std::int64_t k = 1; k <= 20'000; ++k) kept += take(100'000 * k);
  EXPECT_GT(kept, 0.5 * 20'000);
}

}  // namespace
}  // namespace asap::asap2022_test
