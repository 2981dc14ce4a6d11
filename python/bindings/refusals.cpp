#include "refusals.hpp"

#include <string>
#include <string_view>

#include "misfit.hpp"
#include "turns.hpp"

namespace asap::python {
namespace {

namespace py = pybind11;
using py::detail::function_record;

using Dispatcher = PyObject* (*)(PyObject*, PyObject* const*, std::size_t, PyObject*);
Dispatcher pybind11_dispatcher = nullptr;  // the same for all functions

constexpr const char* kIncompatible = "(): incompatible ";
constexpr const char* kUnsized = "len() of unsized object";  // of an array without dimensions

// pybind11 allocates an object when it is first used before its __init__; this stands in the place
// of the allocation.
void* refuse_unmade(std::size_t) {
  throw py::type_error(
      "an object of asap without __init__: make it by its constructor; a subclass with an __init__ "
      "of its own calls super().__init__(...) first");
}

// Python's own way for pickle of protocol 0 and 1 calls pybind11's nameless base class, which ends
// the process.
py::object refuse_copy(const py::object&) {
  throw py::type_error("this object cannot be copied or pickled: make another one");
}

bool is_of_pybind11(const py::error_already_set& error, const function_record& function) {
  const auto text = py::cast<std::string>(py::str(error.value()));
  return text == kUnsized || text.starts_with(std::string(function.name) + kIncompatible);
}

void explain(const function_record& function, const Call& call) {
  py::error_already_set error;
  try {
    if (function.next == nullptr && is_of_pybind11(error, function)) {
      if (const auto misfit = find_misfit(function.signature, call)) {
        py::set_error(misfit->error, misfit->message.c_str());
        return;
      }
    }
    error.restore();
  } catch (py::error_already_set& own) {  // of an argument
    own.restore();
  }
}

// pybind11 ends the process over a name that has no UTF-8.
bool have_text(PyObject* names) {
  for (Py_ssize_t i = 0; names != nullptr && i < PyTuple_GET_SIZE(names); ++i) {
    PyObject* name = PyTuple_GET_ITEM(names, i);
    if (PyUnicode_AsUTF8AndSize(name, nullptr) != nullptr) continue;
    PyErr_Clear();
    PyErr_Format(PyExc_TypeError, "%A: no such argument", name);
    return false;
  }
  return true;
}

PyObject* call(PyObject* self, PyObject* const* values, std::size_t count, PyObject* names) {
  if (!have_text(names)) return nullptr;
  const auto by_position = static_cast<std::size_t>(PyVectorcall_NARGS(count));
  PyObject* result = pybind11_dispatcher(self, values, count, names);
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError) != 0) {
    explain(*py::detail::function_record_ptr_from_PyObject(self), {values, by_position, names});
  }
  return result;
}

PyObject* dispatch(PyObject* self, PyObject* const* values, std::size_t count, PyObject* names) {
  const bool has_object = PyVectorcall_NARGS(count) > 0;
  const CallersTurn turn(has_object ? turns_under_way_at(values[0]) : nullptr);
  return call(self, values, count, names);
}

// Of what works without the GIL.
PyObject* dispatch_work(PyObject* self, PyObject* const* values, std::size_t count,
                        PyObject* names) {
  const bool has_object = PyVectorcall_NARGS(count) > 0;
  const CallersTurn turn(has_object ? turns_at(values[0]) : nullptr);
  return call(self, values, count, names);
}

PyCFunction as_method(Dispatcher function) {
  return reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(function));
}

// pybind11 would cut np.float32(1.9) or a Decimal down to a whole number.
void take_whole_numbers_only(function_record& function) {
  const std::string_view signature = function.signature;
  for (auto& argument : function.args) {
    if (argument.name == nullptr) continue;
    const std::string typed = " " + std::string(argument.name) + ": " + std::string(kWholeNumber);
    if (signature.find(typed) != std::string_view::npos) argument.convert = false;
  }
}

void refuse_in_function(py::handle bound) {
  const py::handle callable = py::detail::get_function(bound);
  if (!callable || PyCFunction_Check(callable.ptr()) == 0) return;
  PyObject* self = PyCFunction_GET_SELF(callable.ptr());
  auto* record = self == nullptr ? nullptr : py::detail::function_record_ptr_from_PyObject(self);
  if (record == nullptr || (record->def->ml_flags & METH_FASTCALL) == 0) return;
  auto* call = reinterpret_cast<Dispatcher>(reinterpret_cast<void (*)()>(record->def->ml_meth));
  if (call == &dispatch || call == &dispatch_work) return;
  pybind11_dispatcher = call;
  take_whole_numbers_only(*record);
  const std::string_view name = record->name;
  const bool works = name == "process" || name == "learn" || name == "apply" || name == "mask" ||
                     name == "check" || name == "check_recorded" || name == "set_keep" ||
                     name == "advance_to";
  record->def->ml_meth = as_method(works ? &dispatch_work : &dispatch);
}

void refuse_in_class(py::handle type) {
  auto* info = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(type.ptr()));
  if (info == nullptr) return;
  info->operator_new = &refuse_unmade;
  const py::handle object_type(reinterpret_cast<PyObject*>(&PyBaseObject_Type));
  if (type.attr("__reduce__").is(object_type.attr("__reduce__"))) {
    type.attr("__reduce__") = py::cpp_function(&refuse_copy, py::is_method(type));
  }
  // Else an object could be told that it is of another class of ours.
  reinterpret_cast<PyTypeObject*>(type.ptr())->tp_flags |= Py_TPFLAGS_IMMUTABLETYPE;
  for (const auto item :
       py::reinterpret_borrow<py::object>(type.attr("__dict__")).attr("values")()) {
    refuse_in_function(item);
    for (const char* part : {"fget", "fset", "__func__"}) {
      refuse_in_function(py::getattr(item, part, py::none()));
    }
  }
}

}  // namespace

void refuse_in_words(const py::module_& m) {
  for (const auto& [name, item] : py::cast<py::dict>(m.attr("__dict__"))) {
    if (PyType_Check(item.ptr()) != 0) {
      refuse_in_class(item);
    } else {
      refuse_in_function(item);
    }
  }
}

}  // namespace asap::python
