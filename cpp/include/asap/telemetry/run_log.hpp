// RunLog: one row per package. Rows live in blocks that are allocated by make_room(), between
// packages and never on the hot path; append() does not allocate. One thread writes; read it when
// the run is over.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace asap {

struct PackageRow {
  std::int64_t index;     // from 0
  double start_us;        // taken, on the recording's own time axis
  double processing_us;   // wall (or virtual) time until the algorithm had finished
  std::int64_t t_first;   // us, oldest kept event
  std::int64_t t_last;    // us, newest kept event
  std::int64_t offered;   // raw events behind the package
  std::int64_t size;      // events kept
  double gamma;           // kept / raw
  double event_rate;      // events/s entering, over the last 1 ms or more
  double rate;            // R: kept events/s, size / max(span, 1 us)
  double margin_us;       // processing time - span
  double latency_max_us;  // of the oldest kept event
  std::int64_t stale;     // events lost as too old since the package before
  std::int64_t overflow;  // events lost to a full ring since the package before
};

class RunLog {
 public:
  static constexpr std::size_t kBlockRows = 4096;

  RunLog() { make_room(); }

  // Makes sure that the next append() has its place; allocates one block in kBlockRows calls.
  void make_room() {
    if (size_ == blocks_.size() * kBlockRows) {
      blocks_.push_back(std::make_unique_for_overwrite<PackageRow[]>(kBlockRows));
    }
  }

  // Precondition: make_room() since the last append().
  void append(const PackageRow& row) noexcept { (*this)[size_++] = row; }

  std::size_t size() const noexcept { return size_; }
  PackageRow& operator[](std::size_t i) noexcept { return blocks_[i / kBlockRows][i % kBlockRows]; }
  const PackageRow& operator[](std::size_t i) const noexcept {
    return blocks_[i / kBlockRows][i % kBlockRows];
  }

 private:
  std::vector<std::unique_ptr<PackageRow[]>> blocks_;
  std::size_t size_ = 0;
};

}  // namespace asap
