#include "native_algorithm.hpp"

#include <map>

namespace asap::python {
namespace {

namespace py = pybind11;

// Types of ours live as long as the process.
std::map<PyObject*, NativeAlgorithm>& known() {
  static auto& all = *new std::map<PyObject*, NativeAlgorithm>;
  return all;
}

std::vector<void (*)(py::module_&)>& bindings() {
  static std::vector<void (*)(py::module_&)> all;
  return all;
}

}  // namespace

void note_native(const py::object& type, const NativeAlgorithm& calls) {
  known()[type.ptr()] = calls;
}

const NativeAlgorithm* native_calls_of(const py::object& object) {
  const auto found = known().find(py::type::of(object).ptr());
  return found == known().end() ? nullptr : &found->second;
}

AlgorithmBinding::AlgorithmBinding(void (*bind)(py::module_&)) { bindings().push_back(bind); }

void bind_algorithms(py::module_& m) {
  for (const auto& bind : bindings()) bind(m);
  const auto listed = [&](auto is_wanted) {
    py::list types;
    for (const auto& [kind, calls] : known()) {
      const py::handle type(kind);
      const bool is_public = py::getattr(m, type.attr("__name__"), py::none()).is(type);
      if (is_public && is_wanted(calls)) types.append(type);
    }
    const py::module_ operators = py::module_::import("operator");
    types.attr("sort")(py::arg("key") = operators.attr("attrgetter")("name"));
    return py::tuple(types);
  };
  m.attr("ALGORITHMS") = listed([](const NativeAlgorithm&) { return true; });
  m.attr("FILTERS") = listed([](const NativeAlgorithm& calls) { return calls.pass != nullptr; });
}

}  // namespace asap::python
