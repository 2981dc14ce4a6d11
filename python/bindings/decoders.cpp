// The layer `formats`: the native decoders, each as a class of Python, and the headers of files.
//
// decode(bytes) makes an array; decode_into(bytes, out) -> (bytes consumed, events written). Both
// keep the triggers that they meet until take_triggers(). GIL released in the loops.
#include <pybind11/gil_safe_call_once.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/formats/aedat.hpp"
#include "asap/formats/atis.hpp"
#include "asap/formats/decoder.hpp"
#include "asap/formats/packets.hpp"
#include "asap/formats/prophesee.hpp"
#include "gil.hpp"
#include "layers.hpp"

namespace asap::python::decoders {

namespace {

using namespace py::literals;

// The bytes of any contiguous buffer, which stays as it is while this lives.
class BytesView {
 public:
  explicit BytesView(py::handle object) {
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_SIMPLE) != 0) throw py::error_already_set();
  }
  ~BytesView() { PyBuffer_Release(&view_); }
  BytesView(const BytesView&) = delete;
  BytesView& operator=(const BytesView&) = delete;

  std::span<const std::byte> bytes() const noexcept {
    return {static_cast<const std::byte*>(view_.buf), static_cast<std::size_t>(view_.len)};
  }

 private:
  Py_buffer view_{};
};

// Fields t, id, value: TRIGGER_DTYPE.
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

// ---- a decoder ----

template <class Decoder>
struct BoundDecoder {
  Decoder decoder;
  std::vector<Trigger> triggers;  // not yet taken

  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) {
    std::array<Trigger, 256> seen;
    Progress all;
    for (;;) {
      const Progress step = decoder.decode(bytes.subspan(all.bytes), events.subspan(all.events),
                                           std::span<Trigger>(seen));
      all.bytes += step.bytes;
      all.events += step.events;
      triggers.insert(triggers.end(), seen.begin(),
                      seen.begin() + static_cast<std::ptrdiff_t>(step.triggers));
      if (step.triggers < seen.size()) return all;
    }
  }

  py::tuple decode_into(const py::buffer& bytes, const py::array& out) {
    const BytesView view(bytes);
    const std::span<Event> events = as_writable_span(out);
    Progress progress;
    {
      const WithoutGil release;  // pure C++ on memory that `bytes` and `out` keep alive
      progress = decode(view.bytes(), events);
    }
    return py::make_tuple(progress.bytes, progress.events);
  }

  py::array decode_all(const py::buffer& bytes) {
    constexpr std::size_t kTypicalRecord = 4;  // bytes per event: room for most inputs at once
    const BytesView view(bytes);
    std::vector<Event> events;
    {
      const WithoutGil release;
      std::span<const std::byte> rest = view.bytes();
      for (std::size_t filled = 0; !rest.empty();) {
        events.resize(filled + rest.size() / kTypicalRecord + Decoder::kMaxPerRecord);
        const Progress progress = decode(rest, std::span(events).subspan(filled));
        rest = rest.subspan(progress.bytes);
        filled += progress.events;
        if (rest.empty()) events.resize(filled);
      }
    }
    return moved_to_array(std::move(events));
  }

  py::array take_triggers() { return moved_to_array(std::exchange(triggers, {}), trigger_dtype()); }
};

// The class without its constructor.
template <class Decoder>
py::class_<BoundDecoder<Decoder>> bind_methods(py::module_& m, const char* name) {
  using Bound = BoundDecoder<Decoder>;
  return py::class_<Bound>(m, name)
      .def("decode", &Bound::decode_all, py::arg("bytes"))
      .def("decode_into", &Bound::decode_into, py::arg("bytes"), py::arg("out"))
      .def("reset",
           [](Bound& bound) {
             bound.decoder.reset();
             bound.triggers.clear();
           })
      .def_property_readonly("unfinished", [](const Bound& b) { return b.decoder.unfinished(); })
      .def_property_readonly("bad_records", [](const Bound& b) { return b.decoder.bad_records(); })
      .def_property_readonly("noted", [](const Bound& b) { return offsets_of(b.decoder.noted()); })
      .def("take_triggers", &Bound::take_triggers)
      .def_property_readonly("triggers", [](const Bound& b) { return b.decoder.triggers(); })
      .def_property_readonly("before_start",
                             [](const Bound& b) { return b.decoder.before_start(); });
}

// `configure` makes the configuration of its arguments, which `names` name.
template <class Decoder, class Config, class... Given, class... Names>
py::class_<BoundDecoder<Decoder>> bind_decoder(py::module_& m, const char* name,
                                               std::function<Config(Given...)> configure,
                                               const Names&... names) {
  return bind_methods<Decoder>(m, name).def(py::init([configure](Given... given) {
                                              return BoundDecoder<Decoder>{
                                                  Decoder(configure(given...)), {}};
                                            }),
                                            py::kw_only(), names...);
}

// A decoder whose configuration is where its bytes stand in the file.
template <class Decoder, class Config>
py::class_<BoundDecoder<Decoder>> bind_with_offset(py::module_& m, const char* name) {
  return bind_decoder<Decoder>(
      m, name, std::function([](const py::object& first_offset) {
        return Config{.first_offset = whole_number("first_offset", first_offset)};
      }),
      py::arg("first_offset") = 0);
}

template <class Decoder>
void bind_packet_decoder(py::module_& m, const char* name) {
  bind_with_offset<Decoder, PacketConfig>(m, name).def(
      "begin",
      [](BoundDecoder<Decoder>& bound, const py::object& time_base_ns) {
        bound.decoder.begin(whole_number("time_base_ns", time_base_ns));
      },
      py::arg("time_base_ns"));
}

// ---- headers: None, or what they say as a dict ----

// A side of the sensor in px; None where the file does not state it.
py::object stated(int side) { return side > 0 ? py::object(py::int_(side)) : py::none(); }

// `read` finds the header, `tell` makes the dict of it, to which the sensor's size is added.
template <class Read, class Tell>
void bind_header(py::module_& m, const char* name, Read read, Tell tell) {
  m.def(
      name,
      [=](const py::buffer& bytes) -> py::object {
        const BytesView view(bytes);
        const auto header = read(view.bytes());
        if (!header) return py::none();
        py::dict told = tell(*header);
        told["width"] = stated(header->width);
        told["height"] = stated(header->height);
        return told;
      },
      py::arg("bytes"));
}

constexpr std::array kChips{"unnamed", "other",  "davis",
                            "dvs128",  "dvs640", "dvs1280"};  // by Aedat2Chip

Aedat2Chip chip_named(const std::string& name) {
  const auto found = std::find(kChips.begin(), kChips.end(), name);
  return found == kChips.end() ? Aedat2Chip::other
                               : static_cast<Aedat2Chip>(found - kChips.begin());
}

void bind_headers(py::module_& m) {
  bind_header(m, "read_raw_header", &read_raw_header, [](const RawHeader& header) {
    constexpr std::array kNames{"", "evt2", "evt21", "evt3"};
    return py::dict("size"_a = header.size,
                    "words"_a = kNames[static_cast<std::size_t>(header.words)],
                    "little_endian"_a = header.little_endian, "is_dat"_a = header.is_dat);
  });
  bind_header(m, "read_dat_header", &read_dat_header, [](const DatHeader& header) {
    return py::dict("size"_a = header.size, "version"_a = header.version,
                    "type"_a = static_cast<int>(header.type),
                    "event_size"_a = static_cast<int>(header.event_size));
  });
  bind_header(m, "read_event_stream_header", &read_event_stream_header,
              [](const EventStreamHeader& header) {
                constexpr std::array kTypes{"generic", "dvs",   "atis",
                                            "display", "color", "unknown"};
                return py::dict("size"_a = header.size, "version"_a = header.version,
                                "type"_a = kTypes[static_cast<std::size_t>(header.type)]);
              });
  bind_header(m, "read_aedat2_header", &read_aedat2_header, [](const Aedat2Header& header) {
    return py::dict("size"_a = header.size,
                    "chip"_a = kChips[static_cast<std::size_t>(header.chip)],
                    "camera_bits"_a = header.camera_bits);
  });
  bind_header(m, "read_aedat3_header", &read_aedat3_header, [](const Aedat3Header& header) {
    return py::dict("size"_a = header.size, "raw"_a = header.raw, "sources"_a = header.sources);
  });
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

void bind(py::module_& m) {
  const auto offset = py::arg("first_offset") = 0;
  m.attr("TRIGGER_DTYPE") = trigger_dtype();
  bind_headers(m);
  bind_with_offset<Evt2Decoder, Evt2Config>(m, "Evt2Decoder");
  bind_with_offset<Evt3Decoder, Evt3Config>(m, "Evt3Decoder")
      .def("resume", [](BoundDecoder<Evt3Decoder>& bound) { bound.decoder.resume(); });
  bind_decoder<Evt21Decoder>(
      m, "Evt21Decoder", std::function([](bool little_endian, const py::object& first_offset) {
        return Evt21Config{.little_endian = little_endian,
                           .first_offset = whole_number("first_offset", first_offset)};
      }),
      py::arg("little_endian") = false, offset);
  bind_decoder<DatDecoder>(
      m, "DatDecoder", std::function([](int version, const py::object& first_offset) {
        return DatConfig{.version = version,
                         .first_offset = whole_number("first_offset", first_offset)};
      }),
      py::arg("version") = 2, offset);
  bind_decoder<EventStreamDecoder>(m, "EventStreamDecoder",
                                   std::function([](int version, std::uint16_t height) {
                                     return EventStreamConfig{.version = version, .height = height};
                                   }),
                                   py::arg("version") = 2, py::arg("height"));
  bind_decoder<Atis40Decoder>(
      m, "Atis40Decoder", std::function([](bool marks) { return Atis40Config{.marks = marks}; }),
      py::arg("marks") = true);
  bind_decoder<Aedat2Decoder>(
      m, "Aedat2Decoder",
      std::function([](const std::string& chip, std::uint16_t width, std::uint16_t height,
                       std::uint32_t camera_bits, std::uint32_t camera) {
        return Aedat2Config{.chip = chip_named(chip),
                            .width = width,
                            .height = height,
                            .camera_bits = camera_bits,
                            .camera = camera};
      }),
      py::arg("chip") = "davis", py::arg("width") = 240, py::arg("height") = 180,
      py::arg("camera_bits") = 0, py::arg("camera") = 0);
  bind_decoder<Aedat3Decoder>(
      m, "Aedat3Decoder", std::function([](int source, const py::object& first_offset) {
        return Aedat3Config{.source = source,
                            .first_offset = whole_number("first_offset", first_offset)};
      }),
      py::arg("source") = -1, offset)
      .def_property_readonly(
          "invalid", [](const BoundDecoder<Aedat3Decoder>& b) { return b.decoder.invalid(); });
  bind_packet_decoder<MonoDecoder>(m, "MonoDecoder");
  bind_packet_decoder<LibcaerDecoder>(m, "LibcaerDecoder");
  bind_packet_decoder<LibcaerCmpDecoder>(m, "LibcaerCmpDecoder");
  m.def("decode_dvs_into", &decode_dvs_into, py::arg("bytes"), py::kw_only(), py::arg("cdr"),
        py::arg("first"), py::arg("out"));
}

}  // namespace asap::python::decoders
