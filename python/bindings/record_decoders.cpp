#include "arguments.hpp"
#include "asap/formats/aedat.hpp"
#include "asap/formats/atis.hpp"
#include "decoders.hpp"
#include "layers.hpp"

namespace asap::python {

namespace {

using namespace py::literals;

// None where the file does not state it.
py::object stated(std::uint16_t side) { return side > 0 ? py::object(py::int_(side)) : py::none(); }

constexpr std::array kChips{"unnamed", "other", "davis", "dvs128"};  // by Aedat2Chip

Aedat2Chip chip_named(const std::string& name) {
  const auto found = std::find(kChips.begin(), kChips.end(), name);
  return found == kChips.end() ? Aedat2Chip::other
                               : static_cast<Aedat2Chip>(found - kChips.begin());
}

// The headers: None, or what they say as a dict.

py::object event_stream_header(const py::buffer& bytes) {
  const BytesView view(bytes);
  const auto header = read_event_stream_header(view.bytes());
  if (!header) return py::none();
  constexpr std::array kTypes{"generic", "dvs", "atis", "display", "color", "unknown"};
  return py::dict("size"_a = header->size, "version"_a = header->version,
                  "type"_a = kTypes[static_cast<std::size_t>(header->type)],
                  "width"_a = stated(header->width), "height"_a = stated(header->height));
}

py::object aedat2_header(const py::buffer& bytes) {
  const BytesView view(bytes);
  const auto header = read_aedat2_header(view.bytes());
  if (!header) return py::none();
  return py::dict("size"_a = header->size,
                  "chip"_a = kChips[static_cast<std::size_t>(header->chip)],
                  "width"_a = stated(header->width), "height"_a = stated(header->height));
}

py::object aedat3_header(const py::buffer& bytes) {
  const BytesView view(bytes);
  const auto header = read_aedat3_header(view.bytes());
  if (!header) return py::none();
  return py::dict("size"_a = header->size, "raw"_a = header->raw, "sources"_a = header->sources,
                  "width"_a = stated(header->width), "height"_a = stated(header->height));
}

}  // namespace

void bind_record_decoders(py::module_& m) {
  m.def("read_event_stream_header", &event_stream_header, py::arg("bytes"));
  m.def("read_aedat2_header", &aedat2_header, py::arg("bytes"));
  m.def("read_aedat3_header", &aedat3_header, py::arg("bytes"));
  bind_decoder<EventStreamDecoder>(m, "EventStreamDecoder")
      .def(py::init([](int version, std::uint16_t height) {
             return BoundDecoder<EventStreamDecoder>{
                 EventStreamDecoder({.version = version, .height = height}), {}};
           }),
           py::kw_only(), py::arg("version") = 2, py::arg("height"));
  bind_decoder<Atis40Decoder>(m, "Atis40Decoder")
      .def(py::init([](bool marks) {
             return BoundDecoder<Atis40Decoder>{Atis40Decoder({.marks = marks}), {}};
           }),
           py::kw_only(), py::arg("marks") = true);
  bind_decoder<Aedat2Decoder>(m, "Aedat2Decoder")
      .def(py::init([](const std::string& chip, std::uint16_t width, std::uint16_t height) {
             return BoundDecoder<Aedat2Decoder>{
                 Aedat2Decoder({.chip = chip_named(chip), .width = width, .height = height}), {}};
           }),
           py::kw_only(), py::arg("chip") = "davis", py::arg("width") = 240,
           py::arg("height") = 180);
  bind_decoder<Aedat3Decoder>(m, "Aedat3Decoder")
      .def(py::init([](int source, const py::object& first_offset) {
             return BoundDecoder<Aedat3Decoder>{
                 Aedat3Decoder({.source = source,
                                .first_offset = whole_number("first_offset", first_offset)}),
                 {}};
           }),
           py::kw_only(), py::arg("source") = -1, py::arg("first_offset") = 0)
      .def_property_readonly(
          "invalid", [](const BoundDecoder<Aedat3Decoder>& b) { return b.decoder.invalid(); });
}

}  // namespace asap::python
