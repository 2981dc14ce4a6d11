// A pipeline that has a thread of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap {
namespace {

using test::evenly_spaced;
using test::Events;

TEST(PipelineWorker, DeliversUntilItIsStopped) {
  const Events events = evenly_spaced(100'000, 1);
  std::uint64_t next = 0;
  Pipeline pipeline{{.latency_us = 1e6}, [&](EventSpan part) {
                      for (const Event& event : part) EXPECT_EQ(test::number_of(event), next++);
                    }};
  for (std::size_t i = 0; i < events.size(); i += 1000) {
    EXPECT_TRUE(pipeline.push(EventSpan(events).subspan(i, 1000)));
  }
  pipeline.stop();
  pipeline.join();
  EXPECT_EQ(next, events.size());
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 100'000, .delivered = 100'000}));
  pipeline.join();  // again: nothing
}

TEST(PipelineWorker, JoinThrowsWhatTheAlgorithmThrew) {
  Pipeline pipeline{{}, [](EventSpan) { throw std::domain_error("of the algorithm"); }};
  pipeline.push(evenly_spaced(10, 1));
  EXPECT_THROW(pipeline.join(), std::domain_error);
  EXPECT_FALSE(pipeline.is_open());
  EXPECT_EQ(pipeline.ledger(), (Ledger{.received = 10, .pending = 10}));
  pipeline.join();  // said once
}

TEST(PipelineWorker, BeginsAnew) {
  std::atomic<std::uint64_t> delivered = 0;
  Pipeline pipeline{{.latency_us = 1e6}, [&](EventSpan part) { delivered += part.size(); }};
  for (std::uint64_t round = 1; round <= 20; ++round) {
    EXPECT_TRUE(pipeline.push(evenly_spaced(100, 1)));
    pipeline.stop();
    pipeline.start();
    EXPECT_EQ(delivered, 100 * round) << "it was drained before";
    EXPECT_EQ(pipeline.ledger(), Ledger{});
  }
}

TEST(PipelineWorker, StopsFromInsideAndCannotWaitForItself) {
  std::atomic<bool> refused = false;
  Pipeline* self = nullptr;
  Pipeline pipeline{{}, [&](EventSpan) {
                      self->stop();
                      try {
                        self->join();
                      } catch (const std::logic_error&) {
                        refused = true;
                      }
                    }};
  self = &pipeline;
  pipeline.push(evenly_spaced(10, 1));
  pipeline.join();
  EXPECT_TRUE(refused);
  EXPECT_EQ(pipeline.ledger().delivered, 10u);
}

TEST(PipelineWorker, GoesAwayInAnyState) {
  for (int events = 0; events < 40; ++events) {
    Pipeline pipeline{{.capacity = 16}, [](EventSpan) {}};
    for (int push = 0; push < events; ++push) pipeline.push(evenly_spaced(3, 1));
  }
}

TEST(PipelineWorker, NeedsAnAlgorithm) {
  EXPECT_EQ(test::error_of([] { Pipeline({}, Consumer{}); }).rfind("algorithm", 0), 0u);
}

}  // namespace
}  // namespace asap
