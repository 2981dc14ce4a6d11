// RunLog: one row per package. The hot path appends a PackageRecord of whole numbers; ratios and
// times on the recording's own axis are made when a row is read. Records live in blocks that are
// allocated by make_room(), between packages and never on the hot path; append() does not allocate.
// One thread writes; read it when the run is over.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "asap/core/time.hpp"

namespace asap {

// What is known when a package is completed. Times in ns are run time.
struct PackageRecord {
  std::int64_t start_ns;       // taken
  std::int64_t processing_ns;  // wall (or virtual) time until the algorithm had finished
  std::int64_t t_first;        // us, oldest kept event
  std::int64_t t_last;         // us, newest kept event
  std::uint64_t offered;       // raw events behind the package
  std::uint64_t size;          // events kept
  std::uint64_t stale;         // events lost as too old since the package before
  std::uint64_t overflow;      // events lost to a full ring since the package before
  std::uint64_t rate_events;   // events that entered ...
  std::int64_t rate_ns;        // ... in this last stretch of time
};

// A row as it is read.
struct PackageRow {
  std::int64_t index;  // from 0
  double start_us;     // taken, on the recording's own time axis
  double processing_us;
  std::int64_t t_first;  // us
  std::int64_t t_last;   // us
  std::int64_t offered;
  std::int64_t size;
  double gamma;           // size / offered
  double event_rate;      // events/s entering, over the last 1 ms or more
  double rate;            // R: kept events/s, size / max(span, 1 us)
  double margin_us;       // processing time - span
  double latency_max_us;  // of the oldest kept event
  std::int64_t stale;
  std::int64_t overflow;
};

class RunLog {
 public:
  static constexpr std::size_t kBlockRows = 4096;

  RunLog() { make_room(); }

  // Where stamps lie in run time; before a row is read.
  void set_axis(TimeAxis axis) noexcept { axis_ = axis; }

  // Makes sure that the next append() has its place; allocates one block in kBlockRows calls.
  void make_room() {
    if (size_ == blocks_.size() * kBlockRows) {
      blocks_.push_back(std::make_unique_for_overwrite<PackageRecord[]>(kBlockRows));
    }
  }

  // Precondition: make_room() since the last append().
  void append(const PackageRecord& record) noexcept {
    blocks_[size_ / kBlockRows][size_ % kBlockRows] = record;
    ++size_;
  }

  std::size_t size() const noexcept { return size_; }
  PackageRow operator[](std::size_t i) const noexcept;

 private:
  std::vector<std::unique_ptr<PackageRecord[]>> blocks_;
  std::size_t size_ = 0;
  TimeAxis axis_;
};

}  // namespace asap
