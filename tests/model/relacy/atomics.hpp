// What the classes under test get instead of atomics, futex and yield: Relacy's. And one main for
// the harnesses.
#pragma once

// Before Relacy, whose macros take over malloc and others.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <memory>
#include <source_location>
#include <span>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "relacy/relacy.hpp"

namespace asap::model {

inline rl::memory_order order_of(std::memory_order order) {
  switch (order) {
    case std::memory_order_relaxed:
      return rl::mo_relaxed;
    case std::memory_order_acquire:
      return rl::mo_acquire;
    case std::memory_order_release:
      return rl::mo_release;
    case std::memory_order_acq_rel:
      return rl::mo_acq_rel;
    default:
      return rl::mo_seq_cst;
  }
}

struct RelacyAtomics {
  template <class Value>
  class Atomic {
   public:
    using Order = std::memory_order;
    using Where = std::source_location;

    Atomic(Value value = {}) : atomic_(value) {}
    Value load(Order order, Where where = Where::current()) const {
      return atomic_.load(order_of(order), where);
    }
    void store(Value value, Order order, Where where = Where::current()) {
      atomic_.store(value, order_of(order), where);
    }
    Value exchange(Value value, Order order, Where where = Where::current()) {
      return atomic_.exchange(value, order_of(order), where);
    }
    Value fetch_or(Value value, Order order, Where where = Where::current()) {
      return atomic_.fetch_or(value, order_of(order), where);
    }
    Value fetch_and(Value value, Order order, Where where = Where::current()) {
      return atomic_.fetch_and(value, order_of(order), where);
    }
    bool compare_exchange_strong(Value& expected, Value value, Order order,
                                 Where where = Where::current()) {
      return atomic_.compare_exchange_strong(expected, value, order_of(order), where);
    }

   private:
    rl::atomic<Value> atomic_;
  };
};

struct RelacyWait {
  static void pause() { rl::yield(1, $); }
};

// The kernel's side of a futex, for one word: compares and falls asleep in one step. No deadline:
// a lost wake-up is a deadlock.
struct RelacySleep {
  struct Queue {
    rl::mutex mutex;
    rl::condition_variable_any sleepers;
  };
  static inline Queue* queue = nullptr;  // of the run in work

  template <class Word, class Deadline>
  static void sleep(Word& word, Deadline) {
    queue->mutex.lock($);
    while (word.load(std::memory_order_relaxed) == 1) queue->sleepers.wait(queue->mutex, $);
    queue->mutex.unlock($);
  }
  template <class Word>
  static void wake(Word&) {
    queue->mutex.lock($);
    queue->sleepers.notify_all($);
    queue->mutex.unlock($);
  }
};

// Arguments: how many random schedules; how deep the exhaustive search by context bound goes.
struct Depth {
  rl::iteration_t schedules;
  unsigned context_bound;

  Depth(int count, char** arguments)
      : schedules(count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 10'000),
        context_bound(count > 2 ? static_cast<unsigned>(std::strtoul(arguments[2], nullptr, 10))
                                : 0) {}
};

// Takes no memory, which Relacy would count.
struct Silence : std::streambuf {
  int overflow(int c) override { return c; }
};

// Ends the program with 1 and a word for what is wrong, when something is. The schedule that shows
// it is printed when RELACY_HISTORY is set.
template <class Test>
void search(const std::string& name, rl::test_params params, const char* how) {
  Silence silence;
  std::ostream nowhere(&silence);
  params.progress_stream = &nowhere;
  params.output_stream = std::getenv("RELACY_HISTORY") != nullptr ? &std::cout : &nowhere;
  params.execution_depth_limit = 4000;
  const bool good = rl::simulate<Test>(params);
  std::printf("%-34s %-10s %9llu schedules  %s\n", name.c_str(), how,
              static_cast<unsigned long long>(params.stop_iteration),
              rl::test_result_str(params.test_result));
  std::fflush(stdout);
  if (!good) std::_Exit(1);
}

template <class Test>
void random(const std::string& name, const Depth& depth) {
  rl::test_params params;
  params.search_type = rl::sched_random;
  params.iteration_count = depth.schedules;
  search<Test>(name, params, "random");
}

// Every schedule with at most so many involuntary switches.
template <class Test>
void exhaustive(const std::string& name, const Depth& depth) {
  if (depth.context_bound == 0) return;
  rl::test_params params;
  params.search_type = rl::sched_bound;
  params.context_bound = depth.context_bound;
  search<Test>(name, params, ("bound " + std::to_string(depth.context_bound)).c_str());
}

}  // namespace asap::model
