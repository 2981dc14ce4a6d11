#include <pybind11/pybind11.h>

#include <string>
#include <string_view>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/formats/text.hpp"
#include "gil.hpp"
#include "layers.hpp"

namespace asap::python {

namespace {

constexpr std::size_t kTypicalLine = 16;  // bytes: enough room for most texts at once

py::array decode(TextDecoder& decoder, const py::bytes& bytes) {
  const std::string_view text = bytes;
  std::vector<Event> events;
  events.reserve(text.size() / kTypicalLine);
  {
    const WithoutGil release;  // pure C++ on memory that `bytes` keeps alive
    decoder.decode(text, events);
  }
  return moved_to_array(std::move(events));
}

// (events of the last line, whether the input ended well)
py::tuple finish(TextDecoder& decoder) {
  std::vector<Event> events;
  const bool ended_well = decoder.finish(events);
  return py::make_tuple(moved_to_array(std::move(events)), ended_well);
}

py::tuple noted(const TextDecoder& decoder) {
  py::tuple offsets(decoder.noted().size());
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = decoder.noted()[i];
  return offsets;
}

}  // namespace

void bind_formats(py::module_& m) {
  py::class_<TextDecoder>(m, "TextDecoder")
      .def(py::init([](const std::string& order, int time_exponent, bool clamp,
                       const py::object& first_offset) {
             return TextDecoder({.order = order,
                                 .time_exponent = time_exponent,
                                 .clamp = clamp,
                                 .first_offset = whole_number("first_offset", first_offset)});
           }),
           py::kw_only(), py::arg("order") = "txyp", py::arg("time_exponent") = 6,
           py::arg("clamp") = false, py::arg("first_offset") = 0)
      .def("decode", &decode, py::arg("bytes"))
      .def("finish", &finish)
      .def_property_readonly("bad_records", &TextDecoder::bad_records)
      .def_property_readonly("out_of_bounds", &TextDecoder::out_of_bounds)
      .def_property_readonly("clamped_positions", &TextDecoder::clamped_positions)
      .def_property_readonly("noted", &noted);
}

}  // namespace asap::python
