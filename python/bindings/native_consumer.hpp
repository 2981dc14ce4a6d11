// How a run calls an algorithm of another extension natively: without the GIL, and anytime. The
// object's attribute `__asap_consumer__` is a capsule of that name with a NativeConsumer in it:
// plain C, so that the two extensions may come from different compilers.
#pragma once

#include <cstddef>

#include "asap/core/event.hpp"

namespace asap::python {

inline constexpr const char* kNativeConsumer = "__asap_consumer__";

struct NativeConsumer {
  void* algorithm;  // lives as long as its Python object

  // For every part of a package; `continues`: not the first. `gamma` of these events.
  void (*process)(void* algorithm, const Event* events, std::size_t size, double gamma,
                  bool continues) noexcept;
};

}  // namespace asap::python
