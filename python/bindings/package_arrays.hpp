// Gives Python a read-only array of each package: a copy into memory that is used again once Python
// has let go of the array, and never before. Copies of this object share the memory and the count.
// With the GIL held.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace asap::python {

class PackageArrays {
 public:
  // Blocks that wait to be used again; more than that are freed.
  static constexpr std::size_t kMostSpare = 4;

  py::array array_of(EventSpan events) {
    std::unique_ptr<Pinned> pinned(new Pinned{pool_, pool_->block_for(events.size())});
    Event* const copy = pinned->block.events.get();
    std::copy(events.begin(), events.end(), copy);
    const py::capsule owner(pinned.get(), [](void* pointer) {
      const std::unique_ptr<Pinned> gone(static_cast<Pinned*>(pointer));
      gone->pool->give_back(std::move(gone->block));
    });
    pinned.release();
    ++pool_->pinned;
    return view_of({copy, events.size()}, owner);
  }

  // Arrays that Python still holds.
  std::size_t pinned() const noexcept { return pool_->pinned; }

 private:
  struct Block {
    std::unique_ptr<Event[]> events;
    std::size_t capacity = 0;
  };

  struct Pool {
    std::vector<Block> spare;
    std::size_t pinned = 0;

    Block block_for(std::size_t size) {
      Block block;
      if (!spare.empty()) {
        block = std::move(spare.back());  // the warmest
        spare.pop_back();
      }
      if (block.capacity < size || !block.events) {
        block.capacity = std::max(size, 2 * block.capacity);
        block.events = std::make_unique_for_overwrite<Event[]>(block.capacity);
      }
      return block;
    }

    void give_back(Block block) {
      --pinned;
      if (spare.size() < kMostSpare) spare.push_back(std::move(block));
    }
  };

  struct Pinned {
    std::shared_ptr<Pool> pool;
    Block block;
  };

  std::shared_ptr<Pool> pool_ = std::make_shared<Pool>();
};

}  // namespace asap::python
