// The layer `formats`: files of words, opened, and the decoders of their records, of the packets in
// ROS messages, and of text.
//
// decode_into(bytes, out) -> (bytes consumed, events written). It keeps the triggers that it meets
// until take_triggers(). GIL released in the loops.
#include <pybind11/gil_safe_call_once.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "arrays.hpp"
#include "asap/formats/decoder.hpp"
#include "asap/formats/packets.hpp"
#include "asap/formats/text.hpp"
#include "formats/opener.hpp"
#include "gil.hpp"
#include "keywords.hpp"

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
      .call_once_and_store_result(
          [] { return aligned_dtype({{"t", "<i8"}, {"id", "<u2"}, {"value", "<u2"}}); })
      .get_stored();
}

template <class Values>
py::tuple tuple_of(const Values& values) {
  py::tuple all(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) all[i] = py::cast(values[i]);
  return all;
}

// ---- a decoder ----

template <class... OfFiles>
auto and_of_packets(std::type_identity<std::variant<OfFiles...>>)
    -> std::variant<OfFiles..., LibcaerDecoder, LibcaerCmpDecoder, MonoDecoder>;
using AnyDecoder = decltype(and_of_packets(std::type_identity<RecordingDecoder>{}));

template <class Decoder>
AnyDecoder made() {
  return Decoder();
}

// The encodings of packets in ROS messages.
constexpr Choices<AnyDecoder (*)(), 4> kPackets{{{"evt3", &made<Evt3Decoder>},
                                                 {"libcaer", &made<LibcaerDecoder>},
                                                 {"libcaer_cmp", &made<LibcaerCmpDecoder>},
                                                 {"mono", &made<MonoDecoder>}}};

struct BoundDecoder {
  AnyDecoder decoder;
  std::vector<Trigger> triggers = {};  // not yet taken

  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) {
    std::array<Trigger, 256> seen;
    Progress all;
    for (;;) {
      const auto use = [&](auto& its) {
        return its.decode(bytes.subspan(all.bytes), events.subspan(all.events),
                          std::span<Trigger>(seen));
      };
      const Progress step = std::visit(use, decoder);
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
    const Progress progress = without_gil([&] { return decode(view.bytes(), events); });
    return py::make_tuple(progress.bytes, progress.events);
  }

  py::array take_triggers() { return moved_to_array(std::exchange(triggers, {}), trigger_dtype()); }

  // Begins a packet, whose times count from this one; words of EVT3 state their own time.
  void begin(const py::object& time_base_ns) {
    const std::uint64_t base_ns = whole_number("time_base_ns", time_base_ns);
    const auto use = [&](auto& its) {
      if constexpr (requires { its.begin(base_ns); }) its.begin(base_ns);
    };
    std::visit(use, decoder);
  }

  // After a packet that never came; words of EVT3 run on across packets.
  void resume() {
    const auto use = [](auto& its) {
      if constexpr (requires { its.resume(); }) its.resume();
    };
    std::visit(use, decoder);
  }
};

void bind_decoder(py::module_& m) {
  py::class_<BoundDecoder> bound(m, "Decoder");
  const auto property = [&](const char* name, auto read) {
    bound.def_property_readonly(name,
                                [=](const BoundDecoder& b) { return std::visit(read, b.decoder); });
  };
  property("unfinished", [](const auto& decoder) { return decoder.unfinished(); });
  property("bad_records", [](const auto& decoder) { return decoder.bad_records(); });
  property("noted", [](const auto& decoder) { return tuple_of(decoder.noted()); });
  property("triggers", [](const auto& decoder) { return decoder.triggers(); });
  property("before_start", [](const auto& decoder) { return decoder.before_start(); });
  bound.def("decode_into", &BoundDecoder::decode_into, py::arg("bytes"), py::arg("out"))
      .def("take_triggers", &BoundDecoder::take_triggers)
      .def("begin", &BoundDecoder::begin, py::arg("time_base_ns"))
      .def("resume", &BoundDecoder::resume);
  m.def(
      "packet_decoder",
      [](const py::object& encoding) {
        return BoundDecoder{chosen(kPackets, "encoding", encoding)()};
      },
      py::arg("encoding"));
  py::list encodings;
  for (const auto& [name, make] : kPackets) encodings.append(name);
  m.attr("PACKET_ENCODINGS") = py::tuple(encodings);
}

// ---- files ----

[[noreturn]] void raise(const py::object& error) {
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
  throw py::error_already_set();
}

OpenedRecording opened(const py::object& path, const std::string& format, int width, int height) {
  const auto native = path.cast<std::filesystem::path>();
  try {
    return without_gil([&] {
      return *open_recording(native, {.format = format, .width = width, .height = height});
    });
  } catch (const BadRecording& error) {
    const py::module_ errors = py::module_::import("asap.io.errors");
    if (error.kind == BadRecording::Kind::corrupt) {
      raise(errors.attr("CorruptFile")(path, error.offset, error.fault));
    }
    raise(errors.attr("UnsupportedFormat")(py::str("{}: {}").format(path, error.fault)));
  } catch (const std::system_error& error) {
    errno = error.code().value();
    PyErr_SetFromErrnoWithFilenameObject(PyExc_OSError, path.ptr());
    throw py::error_already_set();
  }
}

// A side of the sensor in px; None where it is not stated.
py::object stated(int side) { return side > 0 ? py::object(py::int_(side)) : py::none(); }

void bind_files(py::module_& m) {
  py::class_<OpenedRecording>(m, "OpenedRecording")
      .def(py::init(&opened), py::arg("path"), py::arg("format"), py::kw_only(),
           py::arg("width") = 0, py::arg("height") = 0)
      .def_readonly("start", &OpenedRecording::start)
      .def_readonly("event_bytes", &OpenedRecording::event_bytes)
      .def_readonly("doubt", &OpenedRecording::doubt)
      .def_property_readonly("size",
                             [](const OpenedRecording& r) {
                               return py::make_tuple(stated(r.width), stated(r.height));
                             })
      .def_property_readonly("streams",
                             [](const OpenedRecording& r) {
                               py::list streams;
                               for (const RecordingStream& stream : r.streams) {
                                 const auto size =
                                     py::make_tuple(stated(stream.width), stated(stream.height));
                                 streams.append(py::make_tuple(stream.name, stream.words, size));
                               }
                               return streams;
                             })
      .def_property_readonly("has_entries",
                             [](const OpenedRecording& r) { return r.entry != nullptr; })
      .def(
          "entry",
          [](const OpenedRecording& r, const py::buffer& piece) -> py::object {
            const auto entry = r.entry(BytesView(piece).bytes());
            return entry ? py::object(py::make_tuple(entry->first, entry->second)) : py::none();
          },
          py::arg("piece"))
      .def(
          "decoder",
          [](const OpenedRecording& r, std::uint64_t first_offset, std::size_t stream) {
            const auto any = [](auto&& its) -> AnyDecoder { return std::move(its); };
            return BoundDecoder{std::visit(any, r.make(first_offset, stream))};
          },
          py::arg("first_offset"), py::arg("stream") = 0);
  m.def("data_end", &data_end, py::arg("path"));
  m.attr("RECORDING_FORMATS") = tuple_of(recording_formats());
  m.def(
      "recording_format",
      [](const py::buffer& front) { return recording_format(BytesView(front).bytes()); },
      py::arg("front"));
}

// ---- text ----

// The room stays, so that an array is as large as its events and touches no fresh memory.
struct DecoderWithRoom : TextDecoder {
  using TextDecoder::TextDecoder;
  std::vector<Event> room;
};

py::array decode(DecoderWithRoom& decoder, const py::bytes& bytes) {
  const std::string_view text = bytes;
  const std::size_t count = without_gil([&] {
    decoder.room.resize(std::max(decoder.room.size(), decoder.room_for(text.size())));
    const auto all = std::as_bytes(std::span(text));
    return decoder.TextDecoder::decode(all, std::span<Event>(decoder.room)).events;
  });
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

void bind_text(py::module_& m) {
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
      .def_property_readonly(
          "noted", [](const DecoderWithRoom& decoder) { return tuple_of(decoder.noted()); });
}

// ---- ROS messages ----

std::size_t decode_dvs_into(const py::buffer& bytes, bool cdr, const py::object& first,
                            const py::array& out) {
  const BytesView view(bytes);
  const DvsRecords records(view.bytes(), cdr ? DvsRecords::Layout::cdr : DvsRecords::Layout::ros1);
  const std::span<Event> events = as_writable_span(out);
  const std::size_t whole = records.whole();
  const std::size_t start = std::min(whole, std::size_t{whole_number("first", first)});
  const std::size_t count = std::min(whole - start, events.size());
  without_gil([&] { records.decode(start, events.first(count)); });
  return count;
}

}  // namespace

void bind(py::module_& m) {
  m.attr("TRIGGER_DTYPE") = trigger_dtype();
  bind_decoder(m);
  bind_files(m);
  bind_text(m);
  m.def("decode_dvs_into", &decode_dvs_into, py::arg("bytes"), py::kw_only(), py::arg("cdr"),
        py::arg("first"), py::arg("out"));
}

}  // namespace asap::python::decoders
