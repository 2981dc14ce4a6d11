#include "front_filter.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

#include "gil.hpp"
#include "native_algorithm.hpp"
#include "package_arrays.hpp"

namespace asap::python {
namespace {

struct PythonFilter {
  py::object filter;
  py::object process;
  PackageArrays arrays;
};

// The last copy of a filter may go where the GIL is not held.
std::shared_ptr<PythonFilter> held(py::object filter, py::object process) {
  return {new PythonFilter{std::move(filter), std::move(process), {}}, [](PythonFilter* gone) {
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

FrontFilter front_filter_of(const py::object& filter) {
  if (filter.is_none()) return {};
  const NativeAlgorithm* calls = native_calls_of(filter);
  if (calls != nullptr && calls->pass != nullptr) return native_front(*calls, filter);
  const bool has_process = py::hasattr(filter, "process");
  if (!has_process && !PyCallable_Check(filter.ptr())) {
    throw py::type_error("before: expected an object with process(events) or a callable, got " +
                         py::cast<std::string>(py::repr(filter)));
  }
  const auto python = held(filter, has_process ? filter.attr("process") : filter);
  return [python](EventSpan events, std::span<Event> out) {
    return with_gil([&] { return pass(*python, events, out); });
  };
}

}  // namespace asap::python
