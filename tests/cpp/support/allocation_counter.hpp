// Counts this thread's calls of operator new and delete, which every test executable replaces.
#pragma once

#include <cstddef>

namespace asap::test {

std::size_t allocations() noexcept;          // calls of operator new
std::size_t allocated_bytes() noexcept;      // that they asked for
std::ptrdiff_t live_allocations() noexcept;  // less those given back by this thread

}  // namespace asap::test
