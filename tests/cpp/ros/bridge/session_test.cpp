#include "ros/bridge/session.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "ros/bridge/package_writer.hpp"
#include "ros/some_events.hpp"
#include "support/errors.hpp"

namespace asap::ros::session_test {
namespace {

using Events = std::vector<Event>;

constexpr double kNoHurry_ms =
    10'000;  // the machine may be busy: nothing is stale, nothing thinned

class Collector : public Receiver {
 public:
  void begin(const Geometry& sensor) override {
    if (refuses) throw std::runtime_error("a sensor of this size does not fit");
    sensors.push_back(sensor);
  }
  bool trigger(const Trigger& trigger) override {
    triggers.emplace_back(trigger.t, events.size());
    return takes_triggers;
  }
  void process(const Package& package, std::int64_t stamp_ns) override {
    entered = true;
    held.wait(true);
    stamps.emplace_back(package.t_first(), stamp_ns);
    events.insert(events.end(), package.events.begin(), package.events.end());
    if (fails) throw std::runtime_error("no room");
  }
  void hurry() noexcept override { ++hurries; }
  bool is_heard() const override { return heard; }
  bool stalled() const override { return stays_away; }

  std::vector<Geometry> sensors;
  std::vector<std::pair<std::int64_t, std::int64_t>> stamps;
  Events events;
  std::vector<std::pair<std::int64_t, std::size_t>> triggers;  // time, events before it
  bool takes_triggers = true;
  int hurries = 0;
  Complaint complaint() override { return complains; }

  Complaint complains;
  bool refuses = false;
  bool fails = false;
  bool heard = true;
  std::atomic<bool> stays_away{false};
  std::atomic<bool> entered{false};
  std::atomic<bool> held{false};
};

struct Fixture {
  Collector collector;
  std::vector<std::string> said;
  std::mutex saying;
  Session session{{.latency_ms = kNoHurry_ms, .feedback = "none"},
                  collector,
                  [this](Level, const std::string& line) {
                    const std::lock_guard lock(saying);
                    said.push_back(line);
                  }};

  std::optional<Refusal> take(const Events& events, std::uint64_t seq, Geometry sensor = {640, 480},
                              std::string_view publisher = "camera", std::int64_t stamp_ns = 0,
                              std::string_view frame_id = "frame", std::int64_t waited_ns = 0) {
    std::vector<std::uint8_t> bytes;
    const auto written = PackageWriter("mono").write(events, bytes);
    return session.take({.publisher = publisher,
                         .frame_id = frame_id,
                         .stamp_ns = stamp_ns,
                         .sensor = sensor,
                         .seq = seq,
                         .time_base = written.time_base,
                         .encoding = "mono",
                         .bytes = std::as_bytes(std::span(bytes)),
                         .waited_ns = waited_ns});
  }
};

std::string value_of(const Facts& facts, const std::string& name) {
  for (const Fact& fact : facts) {
    if (fact.name == name) return fact.value;
  }
  return "missing";
}

TEST(Session, EveryEventReachesTheReceiver) {
  Fixture fixture;
  const Events events = test::some_events(10'000);
  for (std::size_t i = 0; i < 10; ++i) {
    const EventSpan part = EventSpan(events).subspan(i * 1'000, 1'000);
    EXPECT_FALSE(fixture.take(Events(part.begin(), part.end()), i));
  }
  fixture.session.stop();
  EXPECT_EQ(fixture.collector.events, events);
  const Ledger ledger = fixture.session.stats().ledger;
  EXPECT_EQ(ledger, (Ledger{.received = 10'000, .delivered = 10'000}));
  EXPECT_EQ(fixture.said.back(), "run ended: received 10000 = delivered 10000");
  EXPECT_EQ(value_of(fixture.session.report().facts, "state"), "stopped");
}

TEST(Session, TriggersComeBeforeThePackageOfTheirTime) {
  for (const bool takes : {true, false}) {
    Fixture fixture;
    fixture.collector.takes_triggers = takes;
    const auto take = [&](std::uint64_t seq, std::vector<std::uint16_t> words) {
      fixture.session.take({.publisher = "camera",
                            .sensor = {640, 480},
                            .seq = seq,
                            .encoding = "evt3",
                            .bytes = std::as_bytes(std::span(words))});
    };
    take(1, {0xa000, 0x8001, 0x6005, 0xa101, 0x0007, 0x2001});  // before a time; edge; event
    take(2, {0xa100});                                          // edge
    take(3, {0x6009, 0x2002});                                  // event, 4 us later
    while (fixture.session.stats().ledger.pending > 0) std::this_thread::yield();
    take(0, {0x8001, 0x6000, 0xa101, 0x0007, 0x2001});  // a new epoch begins with an edge
    take(1, {0x6005, 0xa000});                          // waits for ever
    fixture.session.stop();
    const auto& passed = fixture.collector.triggers;
    ASSERT_EQ(passed.size(), 3u);
    EXPECT_EQ(passed[0], (std::pair<std::int64_t, std::size_t>{4'101, 0}));
    EXPECT_EQ(passed[1].first, 4'101);
    EXPECT_EQ(passed[2], (std::pair<std::int64_t, std::size_t>{4'106, 2}));
    const Facts facts = fixture.session.report().facts;
    EXPECT_EQ(value_of(facts, "triggers.received"), "5");
    EXPECT_EQ(value_of(facts, "triggers.passed"), takes ? "3" : "0");
    EXPECT_EQ(std::ranges::count(fixture.said,
                                 "external triggers do not pass; packages in evt3 have them"),
              takes ? 0 : 1);
  }
}

TEST(Session, RunsTheSchemeThatTheParametersSay) {
  Collector collector;
  Session session({.latency_ms = 25, .prefer = "events"}, collector,
                  [](Level, const std::string&) {});
  session.take({.sensor = {640, 480}, .encoding = kDecoded});
  EXPECT_EQ(session.stats().latency_bound_ns, 25'000'000);
  EXPECT_EQ(value_of(session.report().facts, "scheme.prefer"), "events");
  const auto refused = [&] {
    Session({.prefer = "all"}, collector, [](Level, const std::string&) {});
  };
  EXPECT_EQ(test::error_of(refused), "prefer = all: must be one of balanced, events, continuity");
}

TEST(Session, HasFactsBeforeTheFirstMessage) {
  Fixture fixture;
  const std::string json = to_json(fixture.session.report().facts);
  EXPECT_NE(json.find(R"("state": "open")"), std::string::npos) << json;
  EXPECT_NE(json.find(R"("ledger": {"received": 0, "delivered": 0)"), std::string::npos) << json;
  EXPECT_NE(json.find(R"("latency_us": {"mean": 0)"), std::string::npos) << json;
  EXPECT_EQ(json.find("nan"), std::string::npos);
}

TEST(Session, NothingIsTakenAfterTheStop) {
  Fixture fixture;
  fixture.take(test::some_events(10), 0);
  fixture.session.stop();
  EXPECT_FALSE(fixture.take(test::some_events(10), 1));
  EXPECT_EQ(fixture.session.stats().ledger.received, 10u);
  EXPECT_EQ(value_of(fixture.session.report().facts, "messages.received"), "1");
}

constexpr auto kSilence = std::chrono::milliseconds(1'050);

TEST(Session, ASilentCameraLosesItsTurn) {
  Fixture fixture;
  const Geometry large{1280, 720};
  EXPECT_FALSE(fixture.take({{600, 400, 1, 10}}, 0, {640, 480}, "old"));
  EXPECT_EQ(fixture.take({{600, 400, 1, 10}}, 1, large, "old"), Refusal::geometry);
  EXPECT_EQ(fixture.take({{1'200, 700, 1, 10}}, 0, large, "new"), Refusal::publisher);
  EXPECT_EQ(fixture.session.report().message, "two cameras: old is heard, new is refused");
  std::this_thread::sleep_for(kSilence);
  EXPECT_FALSE(fixture.take({{1'200, 700, 1, 10}}, 1, large, "new"));
  EXPECT_EQ(fixture.take({{600, 400, 1, 20}}, 2, {640, 480}, "old"), Refusal::publisher);
  EXPECT_FALSE(fixture.take({{1'200, 700, 1, 20}, {1'300, 700, 1, 21}}, 2, large, "new"));
  fixture.session.stop();
  EXPECT_EQ(fixture.collector.sensors, (std::vector<Geometry>{{640, 480}, large}));
  EXPECT_EQ(fixture.collector.hurries, 2);
  EXPECT_EQ(fixture.session.stats().ledger, (Ledger{.received = 3, .rejected = 1, .delivered = 2}));
  const Facts facts = fixture.session.report().facts;
  EXPECT_EQ(value_of(facts, "rejected.out_of_bounds"), "1");
  EXPECT_EQ(value_of(facts, "messages.refused_geometry"), "1");
  EXPECT_EQ(value_of(facts, "messages.refused_publisher"), "2");
  EXPECT_EQ(std::ranges::count_if(fixture.said,
                                  [](auto& line) { return line.starts_with("message refused"); }),
            2)
      << "once a second";
}

TEST(Session, AClockThatBeginsAnewLosesNoEventAndKeepsItsStamps) {
  Fixture fixture;
  const std::int64_t stamp_ns = 1'700'000'000'000'000'000;
  const auto take = [&](std::int64_t t, std::uint64_t seq, const char* publisher, int at_ms) {
    fixture.take({{1, 1, 1, t}, {1, 1, 1, t + 100}}, seq, {640, 480}, publisher,
                 stamp_ns + at_ms * 1'000'000);
  };
  take(70'000, 5, "camera", 0);
  take(80'000, 6, "camera", 10);
  take(69'000, 0, "camera", 20);  // a bag that loops
  take(79'000, 1, "camera", 30);
  std::this_thread::sleep_for(kSilence);
  take(60'000, 0, "again", 2'000);  // a driver that was started again
  fixture.session.stop();
  EXPECT_EQ(fixture.session.stats().ledger, (Ledger{.received = 10, .delivered = 10}));
  EXPECT_EQ(fixture.session.stats().clock_resets, 2u);
  // Event times go on: 10 ms between two messages, 1 us from one epoch to the next.
  const auto at = [&](std::int64_t t) {
    if (t < 80'100 + 1) return stamp_ns + (t - 70'000) * 1'000;
    if (t < 90'201 + 1) return stamp_ns + 20'000'000 + (t - 80'101) * 1'000;
    return stamp_ns + 2'000'000'000 + (t - 90'202) * 1'000;
  };
  for (const auto& [t_us, at_ns] : fixture.collector.stamps) EXPECT_EQ(at_ns, at(t_us)) << t_us;
  EXPECT_EQ(fixture.collector.stamps.back().first / 100, 902);
}

TEST(Session, CountsWhatTheDriverLost) {
  Fixture fixture;
  for (const std::uint64_t seq : {3u, 4u, 9u, 11u}) {
    const auto t = static_cast<std::int64_t>(seq);
    EXPECT_FALSE(fixture.take({{1, 1, 1, t}}, seq));
  }
  const PipelineStats stats = fixture.session.stats();
  EXPECT_EQ(stats.upstream_marks, 2u);
  EXPECT_EQ(stats.upstream_packets, 5u);
}

TEST(Session, CountsRefusalsByReason) {
  Fixture fixture;
  EXPECT_EQ(fixture.session.take({.sensor = {640, 480}, .encoding = "evt4"}), Refusal::encoding);
  EXPECT_EQ(fixture.session.take({.sensor = {0, 480}, .encoding = "evt3"}), Refusal::geometry);
  const Facts facts = fixture.session.report().facts;
  EXPECT_EQ(value_of(facts, "messages.refused_encoding"), "1");
  EXPECT_EQ(value_of(facts, "messages.refused_geometry"), "1");
  EXPECT_EQ(value_of(facts, "messages.received"), "2");
}

TEST(Session, ReportsWhatIsWrong) {
  Fixture fixture;
  const auto message = [&] { return fixture.session.report("/events").message; };
  EXPECT_EQ(message(), "no message on /events");
  fixture.take({{1, 1, 1, 1}}, 0);
  EXPECT_EQ(message(), "ok");
  EXPECT_EQ(message(), "no message on /events for 0 s");
  fixture.take({{1, 1, 1, 2}}, 3);
  EXPECT_EQ(message(), "2 messages are missing: lost by the driver or the network");
  const std::string refusal =
      R"(1 messages refused: encoding (from a driver in this process with the frame "", encoding )"
      R"("evt4", 640 x 480 px, 0 bytes); evt3, libcaer, libcaer_cmp and mono are read)";
  fixture.session.take({.sensor = {640, 480}, .encoding = "evt4"});
  Session::Report report = fixture.session.report("/events");
  EXPECT_EQ(report.level, Level::error);
  EXPECT_EQ(report.message, refusal);
  fixture.take({{1, 1, 1, 3}}, 4);
  fixture.session.take({.sensor = {640, 480}, .encoding = "evt4"});
  report = fixture.session.report("/events");
  EXPECT_EQ(report.level, Level::warn);
  EXPECT_EQ(report.message, refusal);
  fixture.take({{1, 1, 1, 2}}, 5);
  report = fixture.session.report("/events");
  EXPECT_EQ(report.level, Level::error);
  EXPECT_EQ(report.message, "100 % of the events rejected: 1 nonmonotonic");
  EXPECT_EQ(value_of(report.facts, "last_second.rejected"), "1");
  EXPECT_EQ(value_of(report.facts, "ledger.received"), "4");
  fixture.take({{1, 1, 1, 9}}, 6);
  fixture.collector.heard = false;
  report = fixture.session.report();
  EXPECT_EQ(report.level, Level::warn);
  EXPECT_EQ(report.message, "no subscriber of the packages");
  fixture.collector.heard = true;
  fixture.collector.stays_away = true;
  fixture.take({{1, 1, 1, 9}}, 7);
  EXPECT_EQ(message(), "stalled: the algorithm has not finished");
  fixture.collector.stays_away = false;
  fixture.collector.complains = {Level::ok, "one is quiet"};
  fixture.take({{1, 1, 1, 9}}, 8);
  EXPECT_EQ(message(), "ok; one is quiet");
  fixture.collector.complains = {Level::warn, "feedback refused"};
  EXPECT_EQ(message(), "no message on /events for 0 s");
  fixture.take({{1, 1, 1, 9}}, 9);
  EXPECT_EQ(message(), "feedback refused");
  EXPECT_EQ(fixture.session.report("", "QoS").message, "QoS");
}

TEST(Session, ReportsTheShareThatIsRejected) {
  Fixture fixture;
  fixture.take({{1, 1, 1, 5}, {640, 1, 1, 6}, {640, 1, 1, 7}, {1, 1, 1, 8}}, 0);
  const Session::Report report = fixture.session.report();
  EXPECT_EQ(report.level, Level::warn);
  EXPECT_EQ(report.message, "50 % of the events rejected: 2 out_of_bounds");
}

// An event is as old as its message, also in the middleware.
TEST(Session, WhatWaitedInTheMiddlewareIsLate) {
  Fixture fixture;
  fixture.session.set({.latency_ms = 1'000, .feedback = "none"});
  fixture.take(test::some_events(100), 0, {640, 480}, "camera", 0, "frame", 5'000'000'000);
  while (fixture.session.stats().ledger.pending > 0) std::this_thread::yield();
  const Session::Report report = fixture.session.report();
  EXPECT_EQ(report.level, Level::warn);
  EXPECT_TRUE(report.message.starts_with("Bottleneck: this machine. 0 % processed in time, p99 "))
      << report.message;
  EXPECT_TRUE(
      report.message.ends_with("ms of 1000 ms; messages waited for 5000 ms in the middleware"))
      << report.message;
  EXPECT_EQ(fixture.said.back(), report.message) << "once in the log";
}

TEST(Session, NamesTheQueueThatLostMessages) {
  Collector collector;
  Session session({.latency_ms = kNoHurry_ms, .queue = 10, .feedback = "none"}, collector,
                  [](Level, const std::string&) {});
  for (std::uint64_t i = 0; i < 10; ++i) {  // each of them waited for the one before
    session.take({.publisher = "camera",
                  .sensor = {640, 480},
                  .seq = i < 1 ? 1 : 5 + i,
                  .encoding = "mono",
                  .waited_ns = 100'000'000});
  }
  EXPECT_EQ(session.report().message, "4 messages are missing: lost in the node's own queue of 10");
}

TEST(Session, TellsCamerasOfItsProcessApart) {
  const Geometry sensor{640, 480};
  for (const char* frame : {"right", "left"}) {  // "left": only the numbers differ
    Fixture fixture;
    const auto right = [&](std::int64_t t) {
      return fixture.take({{1, 1, 1, 1'000'000 + t}}, static_cast<std::uint64_t>(t), sensor, "", 0,
                          frame);
    };
    for (std::int64_t t = 10; t < 20; ++t) {
      EXPECT_FALSE(
          fixture.take({{1, 1, 1, t}}, static_cast<std::uint64_t>(100 + t), sensor, "", 0, "left"));
      EXPECT_EQ(right(t), Refusal::publisher);
    }
    EXPECT_EQ(fixture.session.report().message,
              R"(two cameras: a driver in this process with the frame "left" is heard, )"
              R"(a driver in this process with the frame ")" +
                  std::string(frame) + R"(" is refused)");
    fixture.session.stop();
    EXPECT_EQ(fixture.session.stats().clock_resets, 0u);
    EXPECT_EQ(fixture.collector.events.size(), 10u);
  }
}

TEST(Session, AStrayDoesNotEndTheRun) {
  Fixture fixture;
  fixture.take({{1, 1, 1, 10}}, 0);
  std::this_thread::sleep_for(kSilence);
  EXPECT_EQ(fixture.take({{1, 1, 1, 10}}, 0, {320, 240}, "stray"), Refusal::publisher);
  EXPECT_FALSE(fixture.take({{1, 1, 1, 20}}, 1));
  EXPECT_EQ(fixture.session.stats().ledger.received, 2u);
}

// Parameters and messages are checked where they come in, and end no process.
TEST(Session, ARunThatCannotBeginIsReportedAndTriedAgain) {
  Fixture fixture;
  fixture.collector.refuses = true;
  EXPECT_FALSE(fixture.take({{1, 1, 1, 10}}, 0));
  const Session::Report report = fixture.session.report();
  EXPECT_EQ(report.level, Level::error);
  EXPECT_EQ(report.message, "no run can begin: a sensor of this size does not fit");
  fixture.collector.refuses = false;
  EXPECT_FALSE(fixture.take({{1, 1, 1, 11}}, 1));
  fixture.session.stop();
  EXPECT_EQ(fixture.session.stats().ledger, (Ledger{.received = 1, .delivered = 1}));
}

TEST(Session, NoPairOfParametersEndsIt) {
  Collector collector;
  std::size_t good = 0;
  const auto values = [](const NumberField& number) {
    return std::array{number.min,     number.max, number.min - 1,
                      number.max * 2, 0.5,        std::numeric_limits<double>::quiet_NaN()};
  };
  for (const NumberField& one : kNumbers) {
    for (const NumberField& other : kNumbers) {
      for (const double first : values(one)) {
        for (const double second : values(other)) {
          Parameters parameters;
          parameters.*one.field = first;
          parameters.*other.field = second;
          try {
            check(parameters);
          } catch (const std::invalid_argument&) {
            EXPECT_THROW(Session(parameters, collector, [](Level, const std::string&) {}),
                         std::invalid_argument);
            continue;
          }
          if (parameters.capacity > 1e6) continue;  // gigabytes
          Session session(parameters, collector, [](Level, const std::string&) {});
          session.take({.publisher = "camera", .sensor = {640, 480}, .seq = 1, .encoding = "mono"});
          session.set(parameters);
          session.report();
          ++good;
        }
      }
    }
  }
  EXPECT_GT(good, 100u);
}

TEST(Session, APackageHasTheStampOfItsFirstEvent) {
  Fixture fixture;
  const std::int64_t stamp_ns = 1'700'000'000'000'000'000;
  fixture.collector.held = true;  // so that later messages wait in one package
  for (const std::int64_t t : {5'000, 5'300, 5'700}) {
    const std::int64_t at_ns = stamp_ns + (t - 5'000) * 1'000;
    fixture.take({{1, 1, 1, t}}, 0, {640, 480}, "camera", at_ns);
    while (!fixture.collector.entered && fixture.session.stats().ledger.stale == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  fixture.collector.held = false;
  fixture.collector.held.notify_all();
  fixture.session.stop();
  if (fixture.session.stats().ledger.stale > 0) GTEST_SKIP() << "the machine stands still";
  ASSERT_FALSE(fixture.collector.stamps.empty());
  EXPECT_LT(fixture.collector.stamps.back().first, 5'700);
  for (const auto& [t_us, at_ns] : fixture.collector.stamps) {
    EXPECT_EQ(at_ns, stamp_ns + (t_us - 5'000) * 1'000);
  }
}

TEST(Session, AReceiverThatFailsIsCountedAndSaidOnce) {
  Fixture fixture;
  fixture.collector.fails = true;
  for (std::uint64_t i = 0; i < 3; ++i) {
    fixture.take({{1, 1, 1, static_cast<std::int64_t>(i)}}, i);
    while (fixture.session.stats().ledger.pending > 0) std::this_thread::yield();
  }
  fixture.session.stop();
  const Session::Report report = fixture.session.report();
  EXPECT_EQ(report.level, Level::error);
  EXPECT_EQ(report.message, "process() throws: no room");
  EXPECT_EQ(value_of(report.facts, "failures.count"), "3");
  EXPECT_EQ(value_of(report.facts, "failures.last"), "process() throws: no room");
  EXPECT_EQ(std::ranges::count(fixture.said, "process() throws: no room"), 1);
  EXPECT_TRUE(fixture.session.stats().ledger.balanced());
}

TEST(Session, IsStalledWithItsReceiver) {
  Fixture fixture;
  fixture.take({{1, 1, 1, 5}}, 0);
  fixture.collector.stays_away = true;
  EXPECT_TRUE(fixture.session.stats().stalled);
  EXPECT_EQ(value_of(fixture.session.report().facts, "state"), "stalled");
}

// The middleware keeps packages for a consumer that stays away. The time that such a package takes
// says nothing about the algorithm.
TEST(Session, PublishesLittleWhileTheConsumerStaysAway) {
  using namespace std::chrono_literals;
  class Away final : public Receiver {
   public:
    void process(const Package& package, std::int64_t) override {
      if (is_away) most_away = std::max(most_away, was_away ? package.events.size() : 0);
      was_away = is_away.load();
      if (was_away) std::this_thread::sleep_for(100ms);  // the feedback's timeout
    }
    bool stalled() const override { return was_away; }

    std::atomic<bool> is_away{false}, was_away{false};
    std::size_t most_away = 0;
  } receiver;
  Session session({.latency_ms = 5}, receiver, [](Level, const std::string&) {});
  std::int64_t t_us = 0;
  const auto feed_for = [&](std::chrono::milliseconds time) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < time) {
      std::vector<std::uint8_t> bytes;
      const Events events = test::some_events(2'000, t_us += 20'000);
      const auto written = PackageWriter("mono").write(events, bytes);
      session.take({.publisher = "camera",
                    .sensor = {640, 480},
                    .seq = static_cast<std::uint64_t>(t_us),
                    .time_base = written.time_base,
                    .encoding = "mono",
                    .bytes = std::as_bytes(std::span(bytes))});
      std::this_thread::sleep_for(1ms);
    }
  };
  feed_for(100ms);
  receiver.is_away = true;
  feed_for(500ms);
  session.stop();
  EXPECT_GT(receiver.most_away, 0u);
  EXPECT_LE(receiver.most_away, Attended::kWhileAway);
  EXPECT_GT(session.stats().ledger.stale, 10'000u);
  EXPECT_TRUE(session.stats().ledger.balanced());
}

TEST(Session, AnotherBoundHoldsFromNowOn) {
  Fixture fixture;
  EXPECT_EQ(fixture.session.stats().latency_bound_ns, 10'000'000'000);  // without a run too
  fixture.session.set({.latency_ms = 20});
  EXPECT_EQ(fixture.session.stats().latency_bound_ns, 20'000'000);
  fixture.take({{1, 1, 1, 5}}, 0);
  EXPECT_EQ(fixture.session.stats().latency_bound_ns, 20'000'000);
  fixture.session.set({.latency_ms = 30});
  EXPECT_EQ(fixture.session.stats().latency_bound_ns, 30'000'000);
  EXPECT_NE(test::error_of([&] { fixture.session.set({.latency_ms = -1}); }), "nothing was thrown");
  EXPECT_EQ(fixture.session.stats().latency_bound_ns, 30'000'000);
}

}  // namespace
}  // namespace asap::ros::session_test
