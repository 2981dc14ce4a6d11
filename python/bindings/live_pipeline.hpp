// LivePipeline: the pipeline as Python holds it. Waits without the GIL and looks at Ctrl-C every 20
// ms; ends when the interpreter exits; refuses a process that was forked from that of
// its making, where other threads may have been inside. Called with the GIL.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "asap/runner/pipeline.hpp"
#include "glimpse.hpp"
#include "package_arrays.hpp"
#include "telemetry.hpp"

namespace asap::python {

struct LivePackage {
  py::array events;
  Package package;  // but for its events, which were the ring's
};

class LivePipeline {
 public:
  LivePipeline(Scheme& scheme, const RunConfig& config);
  // In a forked process nothing is destroyed: a lock inside may be held by a thread that is gone.
  ~LivePipeline();
  LivePipeline(const LivePipeline&) = delete;
  LivePipeline& operator=(const LivePipeline&) = delete;

  // False: refused, nothing is counted. Waits only where the ring's rule is to block. While the
  // program ends events are taken and stay pending, without a word.
  bool push(const py::array& events, std::optional<double> arrival_time);

  // None: stopped.
  std::optional<LivePackage> next();

  // Until it is stopped; `poll` is called about every 20 ms.
  void run(const py::object& algorithm, const py::object& poll);

  // As Pipeline's.
  void flush();
  void stop(bool drain);
  void start();
  void set_latency(std::chrono::nanoseconds latency);
  void upstream_lost(std::uint64_t marks, std::uint64_t packets);
  bool is_open() const { return native().is_open(); }
  Ledger ledger() const;
  PipelineStats stats() const;

  // Nothing in a forked process, so that a with block can be left there.
  void abandon();

  // The newest rows of the log: a copy. RuntimeError before the end of the run.
  py::array packages() const;

  // Those that the log keeps of the rows from number `since` on. The consumer's thread, between
  // two packages.
  py::array rows(std::size_t since) const { return rows_of(native().log(), since); }

  // Some of the events that came to the algorithm since the call before, if that one wanted more.
  py::array glimpse(bool more);

  // Arrays of packages that Python still holds.
  std::size_t pinned() const noexcept { return arrays_.pinned(); }

 private:
  class Guest;

  Pipeline& native() const;
  template <class Work>
  auto unheld(Work work) const;  // without the GIL, on what `native` returns
  void require_own_process() const;
  void look_up() const;     // what a thread that waits must not miss: Ctrl-C, a fork
  void stop_if_deserted();  // at the end of the program
  Ledger booked(Ledger ledger) const noexcept;  // with the events that came at the end

  std::shared_ptr<Pipeline> pipeline_;
  const std::uint64_t forks_;
  const bool push_may_wait_;
  std::uint64_t came_at_exit_ = 0;  // events
  bool deserted_ = false;           // no thread is left that would stop it
  PackageArrays arrays_;
  Glimpse glimpse_;
  mutable int guests_ = 0;  // threads that may change the log
};

// Ends all pipelines, when the interpreter exits. Once, when the module is made.
void stop_pipelines_on_exit();

}  // namespace asap::python
