#include "consumer.hpp"

#include <algorithm>
#include <memory>

#include "arrays.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/study/busy_wait.hpp"

namespace asap::python {
namespace {

// Gives Python a read-only array of each package. An array that Python keeps stays valid: its
// memory is then left to it and the next package gets new memory.
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

// Destroyed with the consumer, which happens while the GIL is held.
struct PythonAlgorithm {
  py::object process;
  py::object set_keep;
  PackageArrays arrays;
};

// Empty: it is none of ours.
Consumer native_consumer_of(const py::object& algorithm) {
  if (py::isinstance<ClusterTracker>(algorithm)) {
    auto* tracker = algorithm.cast<ClusterTracker*>();
    return [tracker](const Package& package) {
      if (!package.continues) tracker->set_keep(package.keep);
      tracker->process(package.events);
    };
  }
  if (py::isinstance<BusyWait>(algorithm)) {
    auto* busy_wait = algorithm.cast<BusyWait*>();
    return [busy_wait](const Package& package) {
      if (!package.continues) busy_wait->begin();
      busy_wait->process(package.events);
    };
  }
  return {};
}

}  // namespace

bool is_native(const py::object& algorithm) {
  return static_cast<bool>(native_consumer_of(algorithm));
}

Consumer consumer_of(const py::object& algorithm) {
  if (algorithm.is_none()) return {};
  if (Consumer native = native_consumer_of(algorithm)) return native;
  const bool has_process = py::hasattr(algorithm, "process");
  if (!has_process && !PyCallable_Check(algorithm.ptr())) {
    throw py::type_error("algorithm: expected an object with process(events) or a callable, got " +
                         py::cast<std::string>(py::repr(algorithm)));
  }
  auto python = std::make_shared<PythonAlgorithm>();
  python->process = has_process ? algorithm.attr("process") : algorithm;
  python->set_keep = py::getattr(algorithm, "set_keep", py::none());
  return [python](const Package& package) {
    const py::gil_scoped_acquire acquire;
    if (!python->set_keep.is_none() && !package.continues) python->set_keep(package.keep);
    python->process(python->arrays.array_of(package.events));
  };
}

}  // namespace asap::python
