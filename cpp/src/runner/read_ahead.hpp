// ReadAhead: decouples the paced producer from a reader of unknown speed (a file, a Python
// generator). The reader's thread feeds and blocks when the blocks are full; the producer's thread
// takes. Events are copied into blocks of fixed size, allocated once. A lock is held for
// bookkeeping only, never while events are copied.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "asap/runner/replay.hpp"

namespace asap::inline v0_1 {

class ReadAhead final : public EventSource {
 public:
  static constexpr std::size_t kBlockEvents = std::size_t{1} << 15;
  static constexpr std::size_t kBlocks = 32;  // 16 MiB in all

  ReadAhead();

  // Reader. Blocks while all blocks are full. false: cancelled, stop reading.
  bool feed(EventSpan events);
  // Reader. No feed follows.
  void finish() noexcept;

  EventSpan next() override;
  void cancel() noexcept override;

 private:
  struct Block {
    std::unique_ptr<Event[]> events;
    std::size_t size = 0;
  };

  std::vector<Block> blocks_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t filled_ = 0;    // blocks fed so far; block i lies at i % kBlocks
  std::size_t released_ = 0;  // blocks that the producer is done with
  std::size_t taken_ = 0;     // blocks handed to the producer
  bool finished_ = false;
  bool cancelled_ = false;
};

}  // namespace asap::inline v0_1
