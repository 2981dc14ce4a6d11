#include "consumer.hpp"

#include <memory>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/study/busy_wait.hpp"
#include "package_arrays.hpp"

namespace asap::python {
namespace {

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
