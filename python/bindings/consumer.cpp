#include "consumer.hpp"

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "gil.hpp"
#include "native_algorithm.hpp"
#include "native_consumer.hpp"

namespace asap::python {
namespace {

// Destroyed with the consumer, which happens while the GIL is held.
struct PythonAlgorithm {
  py::object process;
  py::object set_gamma;
  PackageArrays arrays;
};

Consumer native(const NativeAlgorithm& calls, const py::object& algorithm) {
  return [calls, inside = calls.open(algorithm),
          passed = std::vector<Event>()](const Package& package) mutable {
    const std::lock_guard turn(inside->turns);
    inside->has_worked = true;
    void* const ours = inside->object.get();
    calls.set_gamma(ours, package.gamma);
    if (calls.pass == nullptr) return calls.process(ours, package.events);
    // What passes goes nowhere: the filter is there to be timed.
    if (passed.size() < package.events.size()) passed.resize(package.events.size());
    calls.pass(ours, package.events, passed);
  };
}

// Empty: it is no algorithm of another extension.
Consumer foreign_native(const py::object& algorithm) {
  const py::object capsule = py::getattr(algorithm, kNativeConsumer, py::none());
  if (PyCapsule_IsValid(capsule.ptr(), kNativeConsumer) == 0) return {};
  const auto native =
      *static_cast<NativeConsumer*>(PyCapsule_GetPointer(capsule.ptr(), kNativeConsumer));
  return [native](const Package& package) {
    native.process(native.algorithm, package.events.data(), package.events.size(), package.gamma,
                   package.continues);
  };
}

// Empty: it has no native loop.
Consumer native_consumer_of(const py::object& algorithm) {
  if (const NativeAlgorithm* calls = native_calls_of(algorithm)) return native(*calls, algorithm);
  return foreign_native(algorithm);
}

}  // namespace

bool is_native(const py::object& algorithm) {
  return static_cast<bool>(native_consumer_of(algorithm));
}

Consumer consumer_of(const py::object& algorithm, PackageArrays arrays) {
  if (algorithm.is_none()) return {};
  if (Consumer native = native_consumer_of(algorithm)) return native;
  const bool has_process = py::hasattr(algorithm, "process");
  if (!has_process && !PyCallable_Check(algorithm.ptr())) {
    throw py::type_error("algorithm: expected an object with process(events) or a callable, got " +
                         py::cast<std::string>(py::repr(algorithm)));
  }
  auto python = std::make_shared<PythonAlgorithm>();
  python->process = has_process ? algorithm.attr("process") : algorithm;
  python->set_gamma = py::getattr(algorithm, "set_gamma", py::none());
  python->arrays = std::move(arrays);
  return [python](const Package& package) {
    with_gil([&] {
      if (!python->set_gamma.is_none()) python->set_gamma(package.gamma);
      python->process(python->arrays.array_of(package.events));
    });
  };
}

}  // namespace asap::python
