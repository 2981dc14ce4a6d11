// Counts this thread's calls of operator new, which every test executable replaces.
#pragma once

#include <cstddef>

namespace asap::test {

std::size_t allocations() noexcept;

}  // namespace asap::test
