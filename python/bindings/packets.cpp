#include "asap/formats/packets.hpp"

#include <algorithm>

#include "arguments.hpp"
#include "decoders.hpp"
#include "layers.hpp"

namespace asap::python {

namespace {

template <class Decoder>
void bind_packet_decoder(py::module_& m, const char* name) {
  bind_decoder<Decoder>(m, name)
      .def(py::init([](const py::object& first_offset) {
             return BoundDecoder<Decoder>{
                 Decoder({.first_offset = whole_number("first_offset", first_offset)}), {}};
           }),
           py::kw_only(), py::arg("first_offset") = 0)
      .def(
          "begin",
          [](BoundDecoder<Decoder>& bound, const py::object& time_base_ns) {
            bound.decoder.begin(whole_number("time_base_ns", time_base_ns));
          },
          py::arg("time_base_ns"));
}

std::size_t decode_dvs_into(const py::buffer& bytes, bool cdr, const py::object& first,
                            const py::array& out) {
  const BytesView view(bytes);
  const DvsRecords records(view.bytes(), cdr ? DvsRecords::Layout::cdr : DvsRecords::Layout::ros1);
  const std::span<Event> events = as_writable_span(out);
  const std::size_t whole = records.whole();
  const std::size_t start = std::min(whole, std::size_t{whole_number("first", first)});
  const std::size_t count = std::min(whole - start, events.size());
  const WithoutGil release;  // pure C++ on memory that `bytes` and `out` keep alive
  records.decode(start, events.first(count));
  return count;
}

}  // namespace

void bind_packets(py::module_& m) {
  bind_packet_decoder<MonoDecoder>(m, "MonoDecoder");
  bind_packet_decoder<LibcaerDecoder>(m, "LibcaerDecoder");
  bind_packet_decoder<LibcaerCmpDecoder>(m, "LibcaerCmpDecoder");
  m.def("decode_dvs_into", &decode_dvs_into, py::arg("bytes"), py::kw_only(), py::arg("cdr"),
        py::arg("first"), py::arg("out"));
}

}  // namespace asap::python
