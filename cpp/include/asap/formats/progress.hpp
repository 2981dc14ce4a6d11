// Progress: what one call of a decoder did. Any thread, plain data.
#pragma once

#include <cstddef>

namespace asap {

struct Progress {
  std::size_t bytes;   // consumed of the input, from its front
  std::size_t events;  // written to the output, from its front
};

}  // namespace asap
