// Which process this is: one that forked has the threads of its parent no more.
#pragma once

#include <cstdint>

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace asap::inline v0_1 {

inline std::int64_t this_process() noexcept {
#if defined(__unix__) || defined(__APPLE__)
  return getpid();
#else
  return 0;
#endif
}

}  // namespace asap::inline v0_1
