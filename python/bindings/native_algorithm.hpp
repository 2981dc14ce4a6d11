// How runners and Python call one of the library's algorithms, whatever its class. The binding of
// an algorithm notes its calls, a runner looks them up.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "asap/core/event.hpp"
#include "held.hpp"

namespace asap::python {

struct NativeAlgorithm {
  Open open;
  void (*process)(void*, EventSpan);                        // null: it is a filter
  std::size_t (*pass)(void*, EventSpan, std::span<Event>);  // null: it is none
  void (*set_gamma)(void*, double);
  void (*reset)(void*);
  std::uint64_t (*rejected)(const void*);
};

template <class Algorithm>
concept Filter = requires {
  static_cast<std::size_t (Algorithm::*)(EventSpan, std::span<Event>)>(&Algorithm::process);
};

template <class Algorithm>
constexpr NativeAlgorithm native_calls() {
  NativeAlgorithm calls{
      .open = &inside_of<Algorithm>,
      .process = nullptr,
      .pass = nullptr,
      .set_gamma = [](void* self,
                      double gamma) { static_cast<Algorithm*>(self)->set_gamma(gamma); },
      .reset = [](void* self) { static_cast<Algorithm*>(self)->reset(); },
      .rejected = [](const void* self) -> std::uint64_t {
        return static_cast<const Algorithm*>(self)->rejected();
      }};
  if constexpr (Filter<Algorithm>) {
    calls.pass = [](void* self, EventSpan events, std::span<Event> passed) -> std::size_t {
      return static_cast<Algorithm*>(self)->process(events, passed);
    };
  } else {
    calls.process = [](void* self, EventSpan events) {
      static_cast<Algorithm*>(self)->process(events);
    };
  }
  return calls;
}

// With the GIL.
void note_native(const pybind11::object& type, const NativeAlgorithm& calls);

// Null: the object is of another class, or of one derived in Python, which may have a process of
// its own. With the GIL; valid for ever.
const NativeAlgorithm* native_calls_of(const pybind11::object& object);

// A file that defines one binds its algorithms when the module is made. asap._core.ALGORITHMS lists
// them, FILTERS those that pass events on.
struct AlgorithmBinding {
  explicit AlgorithmBinding(void (*bind)(pybind11::module_&));
};
void bind_algorithms(pybind11::module_& m);

}  // namespace asap::python
