#include "held.hpp"

#include <string>

#include "gil.hpp"

namespace asap::python {
namespace {

namespace py = pybind11;

py::object refuse_to_pickle(const py::object& self) {
  const auto name = py::cast<std::string>(py::type::of(self).attr("__name__"));
  throw py::type_error("cannot pickle " + name);
}

}  // namespace

bool Turns::try_lock() noexcept {
  std::uint32_t own = serving_.load(std::memory_order_acquire);
  if (!next_.compare_exchange_strong(own, own + 1, std::memory_order_acquire)) return false;
  owner_ = std::this_thread::get_id();
  return true;
}

void Turns::lock() noexcept {
  const std::uint32_t own = next_.fetch_add(1, std::memory_order_relaxed);
  for (;;) {
    const std::uint32_t now = serving_.load(std::memory_order_acquire);
    if (now == own) break;
    serving_.wait(now, std::memory_order_acquire);
  }
  owner_ = std::this_thread::get_id();
}

void Turns::unlock() noexcept {
  owner_ = std::thread::id();
  serving_.fetch_add(1, std::memory_order_release);
  serving_.notify_all();
}

CallersTurn::CallersTurn(Turns& turns) {
  if (turns.are_mine()) return;
  if (!turns.try_lock()) {
    if (is_exiting()) return;
    const WithoutGil release;  // the other thread may need it to come to its end
    turns.lock();
  }
  turns_ = &turns;
}

CallersTurn::~CallersTurn() {
  if (turns_ != nullptr) turns_->unlock();
}

void def_property(const py::object& type, const char* name, const py::cpp_function& get,
                  const char* doc) {
  const py::handle property(reinterpret_cast<PyObject*>(&PyProperty_Type));
  type.attr(name) = property(get, py::none(), py::none(), doc);
}

void close_classes(const py::module_& m) {
  const py::handle plain(reinterpret_cast<PyObject*>(&PyBaseObject_Type));
  for (const auto& [name, item] : py::cast<py::dict>(m.attr("__dict__"))) {
    if (PyType_Check(item.ptr()) == 0) continue;
    if (item.attr("__reduce__").is(plain.attr("__reduce__"))) {
      item.attr("__reduce__") = py::cpp_function(&refuse_to_pickle, py::is_method(item));
    }
    reinterpret_cast<PyTypeObject*>(item.ptr())->tp_flags |= Py_TPFLAGS_IMMUTABLETYPE;
  }
}

}  // namespace asap::python
