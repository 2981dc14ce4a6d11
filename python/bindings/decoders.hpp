// bind_decoder<Decoder>(m, "Evt2Decoder"): a native decoder as a class of Python, without its
// constructor, which the caller adds. GIL released in the loop.
//
// decode(bytes) makes an array; decode_into(bytes, out) -> (bytes consumed, events written). Both
// keep the triggers that they meet until take_triggers().
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "asap/formats/decoder.hpp"
#include "gil.hpp"

namespace asap::python {

// The bytes of any contiguous buffer, which stays as it is while this lives.
class BytesView {
 public:
  explicit BytesView(py::handle object);
  ~BytesView() { PyBuffer_Release(&view_); }
  BytesView(const BytesView&) = delete;
  BytesView& operator=(const BytesView&) = delete;

  std::span<const std::byte> bytes() const noexcept {
    return {static_cast<const std::byte*>(view_.buf), static_cast<std::size_t>(view_.len)};
  }

 private:
  Py_buffer view_{};
};

// The events of a writable array in EVENT_DTYPE, to be filled.
std::span<Event> as_writable_span(const py::array& out);

// Fields t, id, value: TRIGGER_DTYPE.
py::dtype trigger_dtype();

py::tuple offsets_of(std::span<const std::uint64_t> noted);

// A side of the sensor in px; None where a header does not state it.
py::object stated(std::uint16_t side);

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
        events.resize(filled + rest.size() / kTypicalRecord + Decoder::kMostPerRecord);
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

template <class Decoder>
py::class_<BoundDecoder<Decoder>> bind_decoder(py::module_& m, const char* name) {
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

}  // namespace asap::python
