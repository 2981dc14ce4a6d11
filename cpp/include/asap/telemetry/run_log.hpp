// RunLog: one row per package. The hot path appends a PackageRecord of whole numbers; ratios and
// times on the recording's own axis are made when a row is read. Records live in blocks that are
// allocated by make_room(), between packages and never on the hot path; append() does not allocate.
// A bounded log keeps the newest rows, and exact totals of all. One thread writes; read rows when
// the run is over, size() and totals() at any time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "asap/core/atomics.hpp"
#include "asap/core/check.hpp"
#include "asap/core/time.hpp"

namespace asap {

// What is known when a package is completed. Times in ns are run time.
struct PackageRecord {
  std::int64_t start_ns;       // taken
  std::int64_t processing_ns;  // wall (or virtual) time until the algorithm had finished
  std::int64_t oldest_ns;      // when the oldest kept event came
  std::int64_t t_first;        // us, oldest kept event
  std::int64_t t_last;         // us, newest kept event
  std::uint64_t offered;       // raw events behind the package
  std::uint64_t filtered;      // of these, dropped by the filter in front
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
  double gamma;           // size / what came to the gamma filter
  double event_rate;      // events/s entering, over the last 1 ms or more
  double rate;            // R: kept events/s, size / max(span, 1 us)
  double margin_us;       // processing time - span
  double latency_max_us;  // of the oldest kept event
  std::int64_t stale;
  std::int64_t overflow;
};

// What all packages of a run come to, exactly, also when the log keeps only the newest rows. One
// thread adds; a copy may be taken by any thread meanwhile.
struct PackageTotals {
  Relaxed<std::uint64_t> count;    // packages
  Relaxed<std::uint64_t> thinned;  // events that came to the gamma filter
  Relaxed<std::uint64_t> size;     // events kept
  Relaxed<std::uint64_t> size_max;
  Relaxed<std::int64_t> processing_ns;
  Relaxed<double> gamma_min = 1.0;

  void add(std::uint64_t package_thinned, std::uint64_t package_size,
           std::int64_t package_processing_ns) noexcept {
    ++count;
    thinned += package_thinned;
    size += package_size;
    size_max = std::max(size_max.load(), package_size);
    processing_ns += package_processing_ns;
    const double gamma = static_cast<double>(package_size) / static_cast<double>(package_thinned);
    gamma_min = std::min(gamma_min.load(), gamma);
  }
};

class RunLog {
 public:
  static constexpr std::size_t kBlockRows = 4096;

  // most_rows: 0 = all rows are kept; else a multiple of kBlockRows, allocated at once.
  explicit RunLog(std::size_t most_rows = 0) : most_rows_(most_rows) {
    require(most_rows % kBlockRows == 0, "most_rows", most_rows, "must be a multiple of 4096");
    do add_block();
    while (allocated() < most_rows);
  }

  // Where stamps lie in run time; before a row is read.
  void set_axis(TimeAxis axis) noexcept { axis_ = axis; }

  // Makes sure that the next append() has its place; allocates one block in kBlockRows calls.
  void make_room() {
    if (size_ == allocated() && most_rows_ == 0) add_block();
  }

  // Precondition: make_room() since the last append().
  void append(const PackageRecord& record) noexcept {
    const std::size_t place = most_rows_ == 0 ? size_.load() : size_ % most_rows_;
    blocks_[place / kBlockRows][place % kBlockRows] = record;
    if (most_rows_ > 0)
      totals_.add(record.offered - record.filtered, record.size, record.processing_ns);
    ++size_;
  }

  // Rows [first(), size()) are kept.
  std::size_t first() const noexcept {
    return most_rows_ > 0 && size_ > most_rows_ ? size_ - most_rows_ : 0;
  }
  std::size_t size() const noexcept { return size_; }
  PackageRow operator[](std::size_t i) const noexcept;

  // Of a bounded log.
  const PackageTotals& totals() const noexcept { return totals_; }

 private:
  std::size_t allocated() const noexcept { return blocks_.size() * kBlockRows; }
  void add_block() {
    blocks_.push_back(std::make_unique_for_overwrite<PackageRecord[]>(kBlockRows));
  }

  const std::size_t most_rows_;
  std::vector<std::unique_ptr<PackageRecord[]>> blocks_;
  Relaxed<std::size_t> size_;
  PackageTotals totals_;
  TimeAxis axis_;
};

}  // namespace asap
