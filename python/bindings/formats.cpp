#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/formats/encoder.hpp"
#include "asap/formats/text.hpp"
#include "core/check.hpp"
#include "gil.hpp"
#include "layers.hpp"

namespace asap::python::formats {

namespace {

// The room stays, so that an array is as large as its events and touches no fresh memory.
struct DecoderWithRoom : TextDecoder {
  using TextDecoder::TextDecoder;
  std::vector<Event> room;
};

py::array decode(DecoderWithRoom& decoder, const py::bytes& bytes) {
  const std::string_view text = bytes;
  std::size_t count = 0;
  {
    const WithoutGil release;  // pure C++ on memory that `bytes` keeps alive
    decoder.room.resize(std::max(decoder.room.size(), decoder.room_for(text.size())));
    const auto all = std::as_bytes(std::span(text));
    count = decoder.TextDecoder::decode(all, std::span<Event>(decoder.room)).events;
  }
  py::array events(event_dtype(), static_cast<py::ssize_t>(count));
  // NumPy would copy field by field.
  if (count > 0) std::memcpy(events.mutable_data(), decoder.room.data(), count * sizeof(Event));
  return events;
}

// (events of the last line, whether the input ended well)
py::tuple finish(DecoderWithRoom& decoder) {
  std::vector<Event> events;
  const bool ended_well = decoder.finish(events);
  return py::make_tuple(moved_to_array(std::move(events)), ended_well);
}

py::tuple noted(const DecoderWithRoom& decoder) {
  py::tuple offsets(decoder.noted().size());
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = decoder.noted()[i];
  return offsets;
}

Encoder make_encoder(const std::string& encoding, const py::object& width,
                     const py::object& height) {
  constexpr std::array<std::string_view, 3> kNames{"evt3", "es", "csv"};
  const auto* const name = std::ranges::find(kNames, encoding);
  if (name == kNames.end()) {
    throw_bad_value("encoding", "'" + encoding + "'", "give evt3, es or csv");
  }
  return Encoder({.encoding = static_cast<Encoding>(name - kNames.begin()),
                  .width = whole_number<std::uint16_t>("width", width),
                  .height = whole_number<std::uint16_t>("height", height)});
}

// (events consumed, bytes written)
py::tuple encode_into(Encoder& encoder, const py::array& events, const py::buffer& out) {
  const EventSpan span = as_span(events);
  const py::buffer_info room = out.request(true);
  const std::span<std::byte> bytes(static_cast<std::byte*>(room.ptr),
                                   static_cast<std::size_t>(room.size * room.itemsize));
  Progress progress;
  {
    const WithoutGil release;  // pure C++ on memory that `events` and `out` keep alive
    progress = encoder.encode(span, bytes);
  }
  return py::make_tuple(progress.events, progress.bytes);
}

}  // namespace

void bind(py::module_& m) {
  py::class_<DecoderWithRoom>(m, "TextDecoder")
      .def(py::init([](const std::string& order, int time_exponent, bool clamp,
                       const py::object& first_offset) {
             return DecoderWithRoom({.order = order,
                                     .time_exponent = time_exponent,
                                     .clamp = clamp,
                                     .first_offset = whole_number("first_offset", first_offset)});
           }),
           py::kw_only(), py::arg("order") = "txyp", py::arg("time_exponent") = 6,
           py::arg("clamp") = false, py::arg("first_offset") = 0)
      .def("decode", &decode, py::arg("bytes"))
      .def("finish", &finish)
      .def_property_readonly("bad_records", &DecoderWithRoom::bad_records)
      .def_property_readonly("out_of_bounds", &DecoderWithRoom::out_of_bounds)
      .def_property_readonly("clamped_positions", &DecoderWithRoom::clamped_positions)
      .def_property_readonly("noted", &noted);
  py::class_<Encoder>(m, "Encoder")
      .def(py::init(&make_encoder), py::arg("encoding"), py::kw_only(), py::arg("width") = 0,
           py::arg("height") = 0)
      .def("header", [](const Encoder& encoder) { return py::bytes(encoder.header()); })
      .def("encode_into", &encode_into, py::arg("events"), py::arg("out"));
}

}  // namespace asap::python::formats
