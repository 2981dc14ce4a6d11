#include "callbacks.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "gil.hpp"
#include "native_algorithm.hpp"
#include "native_consumer.hpp"

namespace asap::python {
namespace {

// The process of an object, or itself.
py::object process_of(const std::string& field, const py::object& worker) {
  if (py::hasattr(worker, "process")) return worker.attr("process");
  if (PyCallable_Check(worker.ptr()) != 0) return worker;
  throw py::type_error(field + ": expected an object with process(events) or a callable, got " +
                       py::cast<std::string>(py::repr(worker)));
}

// ---- the algorithm ----

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

// ---- the filter in front ----

struct PythonFilter {
  py::object process;
  PackageArrays arrays;
};

// The last copy of a filter may go where the GIL is not held.
std::shared_ptr<PythonFilter> held(py::object process) {
  return {new PythonFilter{std::move(process), {}}, [](PythonFilter* gone) {
            const WithGil gil;
            delete gone;
          }};
}

FrontFilter native_front(const NativeAlgorithm& calls, const py::object& filter) {
  return [pass = calls.pass, inside = calls.open(filter)](EventSpan events, std::span<Event> out) {
    const std::lock_guard turn(inside->turns);
    inside->has_worked = true;
    return pass(inside->object.get(), events, out);
  };
}

// With the GIL.
std::size_t pass(PythonFilter& python, EventSpan events, std::span<Event> out) {
  const py::object answer = python.process(python.arrays.array_of(events));
  if (!py::isinstance<py::array>(answer)) {
    throw py::type_error("before: process(events) returned " +
                         py::cast<std::string>(py::repr(py::type::of(answer))) +
                         ", expected the events that pass, an array in EVENT_DTYPE");
  }
  const auto array = py::array::ensure(answer, py::array::c_style);  // events[::2] is an answer
  const EventSpan passed = as_span(array);
  if (passed.size() > events.size()) {
    throw py::value_error("before: process(events) returned " + std::to_string(passed.size()) +
                          " of " + std::to_string(events.size()) +
                          " events; a filter does not add any");
  }
  const auto back = std::ranges::adjacent_find(passed, std::greater<>(), &Event::t);
  if (back != passed.end()) {
    throw py::value_error("before: process(events) returned t = " + std::to_string(back[1].t) +
                          " after " + std::to_string(back->t) + "; a filter keeps the order");
  }
  std::copy(passed.begin(), passed.end(), out.begin());
  return passed.size();
}

}  // namespace

bool is_native(const py::object& algorithm) {
  return static_cast<bool>(native_consumer_of(algorithm));
}

Consumer consumer_of(const py::object& algorithm, PackageArrays arrays) {
  if (algorithm.is_none()) return {};
  if (Consumer native = native_consumer_of(algorithm)) return native;
  auto python = std::make_shared<PythonAlgorithm>();
  python->process = process_of("algorithm", algorithm);
  python->set_gamma = py::getattr(algorithm, "set_gamma", py::none());
  python->arrays = std::move(arrays);
  return [python](const Package& package) {
    with_gil([&] {
      if (!python->set_gamma.is_none()) python->set_gamma(package.gamma);
      python->process(python->arrays.array_of(package.events));
    });
  };
}

FrontFilter front_filter_of(const py::object& filter) {
  if (filter.is_none()) return {};
  const NativeAlgorithm* calls = native_calls_of(filter);
  if (calls != nullptr && calls->pass != nullptr) return native_front(*calls, filter);
  const auto python = held(process_of("before", filter));
  return [python](EventSpan events, std::span<Event> out) {
    return with_gil([&] { return pass(*python, events, out); });
  };
}

}  // namespace asap::python
