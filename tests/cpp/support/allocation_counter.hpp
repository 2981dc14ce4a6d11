// Counts this thread's calls of operator new and delete, which every test executable replaces, and
// lets them fail.
#pragma once

#include <cstddef>

namespace asap::test {

std::size_t allocations() noexcept;          // calls of operator new
std::size_t allocated_bytes() noexcept;      // that they asked for
std::ptrdiff_t live_allocations() noexcept;  // less those given back by this thread

// So many more allocations of this thread succeed while the object lives.
class LastAllocations {
 public:
  explicit LastAllocations(std::size_t more) noexcept;
  ~LastAllocations();
  LastAllocations(const LastAllocations&) = delete;
  LastAllocations& operator=(const LastAllocations&) = delete;
};

// What make() gives (an asap::Result) where memory ends at each of its allocations in turn: a
// message, and nothing kept. Returns how many allocations it took to get an object, or, negative,
// one less than those at which something was wrong.
template <class Make>
std::ptrdiff_t allocations_until_made(const Make& make) {
  for (std::ptrdiff_t left = 0;; ++left) {
    const std::ptrdiff_t before = live_allocations();
    {
      const auto result = [&] {
        const LastAllocations last(static_cast<std::size_t>(left));
        return make();
      }();
      if (result) return left;
      if (result.message().empty()) return -left - 1;
    }
    if (live_allocations() != before) return -left - 1;
  }
}

}  // namespace asap::test
