// RunLog: one row per package. The hot path appends a PackageRecord of whole numbers; ratios and
// times on the recording's own axis are made when a row is read. Records live in blocks that are
// allocated by make_room(), between packages and never on the hot path; append() does not allocate.
// A bounded log keeps the newest rows, none if its bound is 0; its totals are of all. One thread
// writes, and may read. Other threads may read totals() meanwhile, the rest when the run is over.
//
//   const RunLog& log = pipeline.log();
//   for (std::size_t i = log.first(); i < log.size(); ++i) draw(log[i].size, log[i].gamma);
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "asap/core/time.hpp"

namespace asap::inline v0_1 {

// What is known when a package is completed. Times in ns are run time.
struct PackageRecord {
  std::int64_t start_ns;       // taken
  std::int64_t processing_ns;  // wall (or virtual) time until the algorithm had finished
  std::int64_t oldest_ns;      // when the oldest kept event came
  std::int64_t t_first;        // us, oldest kept event
  std::int64_t t_last;         // us, newest kept event
  std::uint64_t offered;       // raw events behind the package
  std::uint64_t filtered;      // offered events that the front filter dropped
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
  double latency_max_us;  // latency of the oldest kept event
  std::int64_t stale;
  std::int64_t overflow;
};

// What all packages of a run come to, exactly, also when the log keeps only the newest rows.
struct PackageTotals {
  std::uint64_t count = 0;     // packages
  std::uint64_t to_gamma = 0;  // events that came to the gamma filter
  std::uint64_t size = 0;      // events kept
  std::uint64_t size_max = 0;
  std::int64_t processing_ns = 0;
  double gamma_min = 1.0;
};

class RunLog {
 public:
  static constexpr std::size_t kBlockRows = 4096;
  static constexpr std::size_t kMaxRows = std::size_t{1} << 40;  // of a bounded log
  static constexpr std::size_t kAllRows = std::numeric_limits<std::size_t>::max();

  // kAllRows: the log grows by blocks. Else the newest max_rows are kept, allocated at once;
  // NoMemory if they cannot be.
  explicit RunLog(std::size_t max_rows = kAllRows)
      : max_rows_(max_rows), block_rows_(max_rows == kAllRows ? kBlockRows : max_rows) {
    blocks_.reserve(1);
    add_block();
  }
  static std::size_t memory_bytes(std::size_t max_rows) noexcept {
    return sizeof(Block) + max_rows * sizeof(PackageRecord);
  }

  // Writes to the memory of a bounded log, so that no page of it is missing later. Before a row.
  void prefault() noexcept { std::fill_n(blocks_[0].get(), block_rows_, PackageRecord{}); }

  // Forgets all rows and totals; keeps the memory.
  void clear() noexcept {
    size_ = 0;
    totals_ = {};
    begin(blocks_[0]);
  }

  // Where timestamps lie in run time; before a row is read.
  void set_axis(TimeAxis axis) noexcept { axis_ = axis; }

  // Makes room for the next append(); allocates one block in kBlockRows calls.
  void make_room() {
    if (next_ == end_ && max_rows_ == kAllRows) add_block();
  }

  // Precondition: make_room() since the last append().
  void append(const PackageRecord& record) noexcept {
    if (next_ == end_) begin(blocks_[0]);  // a bounded log begins again at its first row
    if (max_rows_ > 0) *next_++ = record;
    ++size_;
    const auto store = [](auto& number, auto value) {
      std::atomic_ref(number).store(value, std::memory_order_relaxed);
    };
    const std::uint64_t to_gamma = record.offered - record.filtered;
    store(totals_.count, totals_.count + 1);
    store(totals_.to_gamma, totals_.to_gamma + to_gamma);
    store(totals_.size, totals_.size + record.size);
    store(totals_.size_max, std::max(totals_.size_max, record.size));
    store(totals_.processing_ns, totals_.processing_ns + record.processing_ns);
    if (record.size == to_gamma) return;
    const double gamma = static_cast<double>(record.size) / static_cast<double>(to_gamma);
    store(totals_.gamma_min, std::min(totals_.gamma_min, gamma));
  }

  // Rows [first(), size()) are kept.
  std::size_t first() const noexcept { return size_ > max_rows_ ? size_ - max_rows_ : 0; }
  std::size_t size() const noexcept { return size_; }
  PackageRow operator[](std::size_t i) const noexcept;

  PackageTotals totals() const noexcept;

 private:
  using Block = std::unique_ptr<PackageRecord[]>;

  void add_block();
  void begin(const Block& block) noexcept {
    next_ = block.get();
    end_ = next_ + block_rows_;
  }
  // Where the record of this row lies. Precondition: some are kept.
  PackageRecord& row(std::size_t i) const noexcept {
    const std::size_t place = max_rows_ == kAllRows ? i : i % max_rows_;
    return blocks_[place / block_rows_][place % block_rows_];
  }

  const std::size_t max_rows_;
  const std::size_t block_rows_;
  std::vector<Block> blocks_;
  std::size_t size_ = 0;
  PackageRecord* next_ = nullptr;  // row of the block ...
  PackageRecord* end_ = nullptr;   // ... which ends here
  PackageTotals totals_;
  TimeAxis axis_;
};

}  // namespace asap::inline v0_1
