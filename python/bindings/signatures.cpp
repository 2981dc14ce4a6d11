#include "signatures.hpp"

#include <cstdlib>
#include <string_view>

namespace asap::python {
namespace {

namespace py = pybind11;
using py::detail::function_record;

constexpr std::string_view kEnd = ")\n--\n\n";  // of a signature, to CPython

std::string signature_of(const function_record& constructor, const std::string& keywords) {
  std::string text = "__init__(self";
  for (std::size_t i = 1; i < constructor.args.size(); ++i) {
    const auto& argument = constructor.args[i];
    if (i == constructor.nargs_pos) text += ", *";
    text.append(", ").append(argument.name);
    if (argument.descr != nullptr) text.append("=").append(argument.descr);
  }
  if (constructor.has_kwargs) text += keywords;
  return text.append(kEnd);
}

// How to make it anew: width and height, where it has them, and what is no default.
py::str how_to_make(const py::object& made, const py::handle& type) {
  const auto signature = py::module_::import("inspect").attr("signature")(type);
  py::list given;
  for (const char* side : {"width", "height"}) {
    if (py::hasattr(made, side)) given.append(py::str(made.attr(side)));
  }
  for (const auto& [name, held] : py::cast<py::dict>(made.attr("parameters"))) {
    auto value = py::reinterpret_borrow<py::object>(held);
    if (py::isinstance<py::list>(value)) value = py::tuple(value);  // as the default is
    if (value.equal(signature.attr("parameters")[name].attr("default"))) continue;
    given.append(py::str("{}={!r}").format(name, value));
  }
  const py::str arguments(py::str(", ").attr("join")(given));
  return py::str("{}({})").format(py::type::of(made).attr("__name__"), arguments);
}

void show_repr(const py::handle& type) {
  const auto own = py::reinterpret_borrow<py::object>(type.attr("__dict__"));
  const bool is_plain =
      reinterpret_cast<PyTypeObject*>(type.ptr())->tp_repr == PyBaseObject_Type.tp_repr;
  if (!own.contains("parameters") || !is_plain) return;
  type.attr("__repr__") =
      py::cpp_function([type](const py::object& made) { return how_to_make(made, type); },
                       py::name("__repr__"), py::is_method(type));
}

}  // namespace

void show_signature(py::handle type, const std::string& keywords) {
  const auto own = py::reinterpret_borrow<py::object>(type.attr("__dict__"));
  if (!own.contains("__init__")) return;
  const py::handle init = py::detail::get_function(own["__init__"]);
  PyObject* self = PyCFunction_Check(init.ptr()) == 0 ? nullptr : PyCFunction_GET_SELF(init.ptr());
  auto* record = self == nullptr ? nullptr : py::detail::function_record_ptr_from_PyObject(self);
  if (record == nullptr || record->next != nullptr) return;
  const char*& text = record->def->ml_doc;
  if (std::string_view(text).find(kEnd) != std::string_view::npos) return;
  char* with_signature = PYBIND11_COMPAT_STRDUP((signature_of(*record, keywords) + text).c_str());
  std::free(const_cast<char*>(text));  // as pybind11 will, with the new one
  text = with_signature;
}

void show_signatures(const py::module_& m) {
  for (const auto& [name, item] : py::cast<py::dict>(m.attr("__dict__"))) {
    if (PyType_Check(item.ptr()) == 0) continue;
    show_signature(item);
    show_repr(item);
  }
}

}  // namespace asap::python
