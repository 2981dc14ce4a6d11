// The layer `formats`: the encoder of recordings.
#include "asap/formats/encoder.hpp"

#include <pybind11/pybind11.h>

#include <cstddef>
#include <span>

#include "arrays.hpp"
#include "gil.hpp"
#include "keywords.hpp"

namespace asap::python::encoder {

namespace {

constexpr Choices<Encoding, 3> kEncodings{
    {{"evt3", Encoding::evt3}, {"es", Encoding::event_stream}, {"csv", Encoding::csv}}};

// (events consumed, bytes written)
py::tuple encode_into(Encoder& encoder, const py::array& events, const py::buffer& out) {
  const EventSpan span = as_span(events);
  const py::buffer_info room = out.request(true);
  const std::span<std::byte> bytes(static_cast<std::byte*>(room.ptr),
                                   static_cast<std::size_t>(room.size * room.itemsize));
  const Progress progress = without_gil([&] { return encoder.encode(span, bytes); });
  return py::make_tuple(progress.events, progress.bytes);
}

}  // namespace

void bind(py::module_& m) {
  py::class_<Encoder>(m, "Encoder")
      .def(py::init(
               [](const py::object& encoding, const py::object& width, const py::object& height) {
                 return Encoder({.encoding = chosen(kEncodings, "encoding", encoding),
                                 .width = whole_number<std::uint16_t>("width", width),
                                 .height = whole_number<std::uint16_t>("height", height)});
               }),
           py::arg("encoding"), py::kw_only(), py::arg("width") = 0, py::arg("height") = 0)
      .def("header", [](const Encoder& encoder) { return py::bytes(encoder.header()); })
      .def("encode_into", &encode_into, py::arg("events"), py::arg("out"));
}

}  // namespace asap::python::encoder
