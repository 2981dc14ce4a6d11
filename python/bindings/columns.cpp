#include <pybind11/numpy.h>

#include <bit>
#include <optional>
#include <span>
#include <vector>

#include "arrays.hpp"
#include "formats/columns.hpp"
#include "gil.hpp"

namespace asap::python::columns {

namespace {

std::optional<Number> number_of(const py::dtype& dtype) {
  constexpr char kForeign = std::endian::native == std::endian::little ? '>' : '<';
  if (dtype.byteorder() == kForeign) return std::nullopt;
  const auto width = [&](Number one, Number two, Number four, Number eight) {
    const auto bytes = dtype.itemsize();
    return bytes == 1 ? one : bytes == 2 ? two : bytes == 4 ? four : eight;
  };
  switch (dtype.kind()) {
    case 'b':
      return Number::u8;
    case 'u':
      return width(Number::u8, Number::u16, Number::u32, Number::u64);
    case 'i':
      return width(Number::i8, Number::i16, Number::i32, Number::i64);
    case 'f':
      return dtype.itemsize() == 8 ? std::optional(Number::f64) : std::nullopt;
    default:
      return std::nullopt;
  }
}

std::optional<NumberColumn> column_of(const py::array& array) {
  const std::optional<Number> number = number_of(array.dtype());
  if (!number || array.ndim() != 1) return std::nullopt;
  return NumberColumn{static_cast<const std::byte*>(array.data()), array.strides(0), *number};
}

// None where a column is of another kind or holds a value that no event can: NumPy then says which.
py::object events_of_columns(const py::array& t, const py::array& x, const py::array& y,
                             const py::object& p, double us_per_unit, bool normalise,
                             const py::object& into) {
  const auto t_column = column_of(t);
  const auto x_column = column_of(x);
  const auto y_column = column_of(y);
  if (!t_column || !x_column || !y_column) return py::none();
  EventColumns columns{.t = *t_column,
                       .x = *x_column,
                       .y = *y_column,
                       .p = std::nullopt,
                       .us_per_unit = us_per_unit,
                       .normalise = normalise};
  const py::ssize_t count = t.size();
  if (x.size() != count || y.size() != count) return py::none();
  if (!p.is_none()) {
    const auto array = py::cast<py::array>(p);
    columns.p = column_of(array);
    if (!columns.p || array.size() != count) return py::none();
  }
  const py::array events = into.is_none()
                               ? py::array(event_dtype(), std::vector<py::ssize_t>{count})
                               : py::cast<py::array>(into);
  const std::span<Event> out = as_writable_span(events);
  if (out.size() != static_cast<std::size_t>(count)) return py::none();
  if (!without_gil([&] { return gather(columns, out); })) return py::none();
  return events;
}

}  // namespace

void bind(py::module_& m) {
  m.def("events_of_columns", &events_of_columns, py::arg("t").noconvert(), py::arg("x").noconvert(),
        py::arg("y").noconvert(), py::arg("p").none(true), py::kw_only(),
        py::arg("us_per_unit") = 1.0, py::arg("normalise") = true, py::arg("out") = py::none());
}

}  // namespace asap::python::columns
