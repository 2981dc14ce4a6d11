// Gives Python a read-only array of each package: a copy into memory that is used again. An array
// that Python keeps stays valid: its memory is then left to it and the next package gets new
// memory. With the GIL held.
#pragma once

#include <algorithm>
#include <cstddef>

#include "arrays.hpp"

namespace asap::python {

class PackageArrays {
 public:
  py::array array_of(EventSpan events) {
    const bool kept = memory_ && memory_.ref_count() > 1;
    if (kept || capacity_ < events.size()) {
      capacity_ = kept ? events.size() : std::max(events.size(), 2 * capacity_);
      memory_ = py::array(event_dtype(), static_cast<py::ssize_t>(capacity_));
    }
    auto* copy = static_cast<Event*>(memory_.mutable_data());
    std::copy(events.begin(), events.end(), copy);
    return view_of({copy, events.size()}, memory_);
  }

 private:
  py::array memory_{py::reinterpret_steal<py::array>(py::handle())};
  std::size_t capacity_ = 0;
};

}  // namespace asap::python
