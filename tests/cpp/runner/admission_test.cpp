#include "runner/admission.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "asap/core/random.hpp"
#include "support/streams.hpp"

namespace asap::admission_test {
namespace {

using test::at_times;
using test::evenly_spaced;
using test::Events;
using test::number_of;

constexpr std::int64_t kMicrosecond = 1000;

class ScriptedAdmission final : public Admission {
 public:
  using Rule = std::function<double(const Arrivals&)>;

  ScriptedAdmission(std::int64_t period_us, Rule rule)
      : period_ns_(period_us * kMicrosecond), rule_(std::move(rule)) {}

  double gamma(const Arrivals& arrivals) noexcept override {
    told.push_back(arrivals);
    return rule_(arrivals);
  }
  std::int64_t period_ns() const noexcept override { return period_ns_; }

  std::vector<Arrivals> told;

 private:
  std::int64_t period_ns_;
  Rule rule_;
};

ScriptedAdmission::Rule always(double gamma) {
  return [=](const Arrivals&) { return gamma; };
}

// A gate with all that it let in.
struct Rig {
  Rig(ScriptedAdmission& admission, std::uint64_t seed = 0) : gate(admission, seed) {}

  void pass(EventSpan events) {
    gate.pass(
        events, TimeAxis(0, 1.0), [&](Arrivals& arrivals) { arrivals.waiting = admitted.size(); },
        [&](EventSpan period) { admitted.insert(admitted.end(), period.begin(), period.end()); });
  }

  AdmissionGate gate;
  Events admitted;
};

TEST(AdmissionGate, AsksFirstAndThenEveryPeriod) {
  ScriptedAdmission admission(100, always(1.0));
  Rig rig(admission);
  rig.pass(at_times({50, 60, 149, 150, 151, 460}));
  ASSERT_EQ(admission.told.size(), 5u);
  const std::vector<std::size_t> arrived{0, 3, 2, 0, 0};  // 150 arrives after the second question
  const std::vector<std::size_t> waiting{0, 3, 5, 5, 5};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(admission.told[i].now_ns, (50 + 100 * static_cast<std::int64_t>(i)) * kMicrosecond);
    EXPECT_EQ(admission.told[i].arrived, arrived[i]) << i;
    EXPECT_EQ(admission.told[i].waiting, waiting[i]) << i;
  }
  EXPECT_EQ(rig.admitted, at_times({50, 60, 149, 150, 151, 460}));
}

TEST(AdmissionGate, TheAnswerHoldsForThePeriodThatFollows) {
  ScriptedAdmission admission(100, [](const Arrivals& arrivals) {
    return arrivals.now_ns % (200 * kMicrosecond) == 0 ? 1.0 : 0.0;
  });
  Rig rig(admission);
  const Events events = evenly_spaced(1000, 1);
  rig.pass(events);
  ASSERT_EQ(rig.admitted.size(), 500u);
  for (const Event& event : rig.admitted) EXPECT_EQ(event.t / 100 % 2, 0) << event.t;
  EXPECT_EQ(rig.gate.seen(), 1000u);
  EXPECT_EQ(rig.gate.discarded(), 500u);
}

TEST(AdmissionGate, CountsWhatArrivesAndNotWhatItLetsIn) {
  ScriptedAdmission admission(100, always(0.0));
  Rig rig(admission);
  rig.pass(evenly_spaced(1000, 1));
  EXPECT_TRUE(rig.admitted.empty());
  ASSERT_EQ(admission.told.size(), 10u);
  for (std::size_t i = 1; i < 10; ++i) EXPECT_EQ(admission.told[i].arrived, 100u);
  EXPECT_EQ(rig.gate.discarded(), 1000u);
}

TEST(AdmissionGate, KeepsWhatTheHashOfSeedAndNumberSays) {
  const Events events = evenly_spaced(5000, 1);
  for (const std::uint64_t seed : {0u, 7u}) {
    ScriptedAdmission admission(100, always(0.3));
    Rig rig(admission, seed);
    rig.pass(events);
    const CounterRandom random(seed);
    Events expected;
    for (std::uint64_t i = 0; i < events.size(); ++i) {
      if ((random(i) >> 1) < KeepThreshold::checked(0.3).value()) expected.push_back(events[i]);
    }
    EXPECT_EQ(rig.admitted, expected);
    EXPECT_EQ(rig.gate.discarded(), events.size() - expected.size());
  }
}

TEST(AdmissionGate, DoesTheSameForAnyChunks) {
  const Events events = test::random_stream(3, 5000);
  const auto rule = [](const Arrivals& arrivals) {
    return 1.0 / (1.0 + static_cast<double>(arrivals.arrived));
  };
  ScriptedAdmission admission(1000, rule);
  Rig whole(admission);
  whole.pass(events);
  for (const std::size_t chunk : {1u, 7u, 1000u}) {
    ScriptedAdmission same(1000, rule);
    Rig rig(same);
    for (std::size_t at = 0; at < events.size(); at += chunk) {
      rig.pass(EventSpan(events).subspan(at, std::min(chunk, events.size() - at)));
      rig.pass({});
    }
    EXPECT_EQ(rig.admitted, whole.admitted);
    EXPECT_EQ(same.told.size(), admission.told.size());
  }
}

struct Trouble {};

TEST(AdmissionGate, KnowsWhatItHasSeenWhenTheSinkThrows) {
  ScriptedAdmission admission(100, always(0.5));
  AdmissionGate gate(admission, 0);
  std::uint64_t let_in = 0;
  const auto look = [](Arrivals&) {};
  const auto sink = [&](EventSpan period) {
    let_in += period.size();
    if (gate.seen() >= 300) throw Trouble{};
  };
  EXPECT_THROW(gate.pass(evenly_spaced(1000, 1), TimeAxis(0, 1.0), look, sink), Trouble);
  EXPECT_EQ(gate.seen(), 300u);
  EXPECT_EQ(gate.seen(), gate.discarded() + let_in);
}

}  // namespace
}  // namespace asap::admission_test
