#include "decoders.hpp"

#include <pybind11/gil_safe_call_once.h>

#include "arguments.hpp"
#include "asap/formats/prophesee.hpp"
#include "layers.hpp"

namespace asap::python {

BytesView::BytesView(py::handle object) {
  if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_SIMPLE) != 0) throw py::error_already_set();
}

std::span<Event> as_writable_span(const py::array& out) {
  const EventSpan events = as_span(out);
  if (!out.writeable()) throw py::value_error("out = read-only array: give a writable one");
  return {const_cast<Event*>(events.data()), events.size()};
}

py::dtype trigger_dtype() {
  PYBIND11_CONSTINIT static py::gil_safe_call_once_and_store<py::dtype> storage;
  return storage
      .call_once_and_store_result([]() -> py::dtype {
        py::list fields;
        fields.append(py::make_tuple("t", "<i8"));
        fields.append(py::make_tuple("id", "<u2"));
        fields.append(py::make_tuple("value", "<u2"));
        return py::module_::import("numpy").attr("dtype")(fields, py::arg("align") = true);
      })
      .get_stored();
}

py::tuple offsets_of(std::span<const std::uint64_t> noted) {
  py::tuple offsets(noted.size());
  for (std::size_t i = 0; i < noted.size(); ++i) offsets[i] = noted[i];
  return offsets;
}

py::object stated(std::uint16_t side) { return side > 0 ? py::object(py::int_(side)) : py::none(); }

namespace {

using namespace py::literals;

template <class Decoder, class Config>
void bind_with_offset(py::module_& m, const char* name) {
  bind_decoder<Decoder>(m, name).def(
      py::init([](const py::object& first_offset) {
        return BoundDecoder<Decoder>{
            Decoder(Config{.first_offset = whole_number("first_offset", first_offset)}), {}};
      }),
      py::kw_only(), py::arg("first_offset") = 0);
}

// None, or the header as a dict; width and height are None where the file does not state them.
py::object raw_header(const py::buffer& bytes) {
  const BytesView view(bytes);
  const auto header = read_raw_header(view.bytes());
  if (!header) return py::none();
  constexpr std::array kNames{"", "evt2", "evt21", "evt3"};
  return py::dict("size"_a = header->size,
                  "words"_a = kNames[static_cast<std::size_t>(header->words)],
                  "little_endian"_a = header->little_endian, "is_dat"_a = header->is_dat,
                  "width"_a = stated(header->width), "height"_a = stated(header->height));
}

py::object dat_header(const py::buffer& bytes) {
  const BytesView view(bytes);
  const auto header = read_dat_header(view.bytes());
  if (!header) return py::none();
  return py::dict("size"_a = header->size, "version"_a = header->version,
                  "type"_a = static_cast<int>(header->type),
                  "event_size"_a = static_cast<int>(header->event_size),
                  "width"_a = stated(header->width), "height"_a = stated(header->height));
}

}  // namespace

void bind_decoders(py::module_& m) {
  m.attr("TRIGGER_DTYPE") = trigger_dtype();
  m.def("read_raw_header", &raw_header, py::arg("bytes"));
  m.def("read_dat_header", &dat_header, py::arg("bytes"));
  bind_with_offset<Evt2Decoder, Evt2Config>(m, "Evt2Decoder");
  bind_with_offset<Evt3Decoder, Evt3Config>(m, "Evt3Decoder");
  bind_decoder<Evt21Decoder>(m, "Evt21Decoder")
      .def(py::init([](bool little_endian, const py::object& first_offset) {
             const Evt21Config config{.little_endian = little_endian,
                                      .first_offset = whole_number("first_offset", first_offset)};
             return BoundDecoder<Evt21Decoder>{Evt21Decoder(config), {}};
           }),
           py::kw_only(), py::arg("little_endian") = false, py::arg("first_offset") = 0);
  bind_decoder<DatDecoder>(m, "DatDecoder")
      .def(py::init([](int version, const py::object& first_offset) {
             const DatConfig config{.version = version,
                                    .first_offset = whole_number("first_offset", first_offset)};
             return BoundDecoder<DatDecoder>{DatDecoder(config), {}};
           }),
           py::kw_only(), py::arg("version") = 2, py::arg("first_offset") = 0);
}

}  // namespace asap::python
