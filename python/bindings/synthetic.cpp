// The layer `synthetic`: streams of synthetic events, read once; asap.synthetic makes them
// iterable.
#include <cstdint>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/synthetic/streams.hpp"
#include "gil.hpp"
#include "layers.hpp"

namespace asap::python::synthetic {
namespace {

py::array read_stream(EventStream& stream, const py::object& at_least) {
  const std::uint64_t count = whole_number("at_least", at_least);
  std::vector<Event> events;
  {
    const WithoutGil release;  // pure C++: other Python threads may run
    events = read_events(stream, count);
  }
  return moved_to_array(std::move(events));
}

}  // namespace

void bind(py::module_& m) {
  py::class_<EventStream>(m, "EventStream", "Synthetic events, made as they are read, once.")
      .def("read", &read_stream, py::arg("at_least"),
           "A new array of at least so many events, fewer at the end, then empty.");

  py::class_<ShakenPattern, EventStream>(m, "ShakenPatternStream")
      .def(py::init([](std::int32_t width, std::int32_t height, std::int64_t duration_us,
                       std::int64_t t0_us, double first_rate_hz, double last_rate_hz,
                       double amplitude_px, double noise_hz, const py::object& seed) {
             return ShakenPattern({.width = width,
                                   .height = height,
                                   .duration = std::chrono::microseconds(duration_us),
                                   .start = std::chrono::microseconds(t0_us),
                                   .first_rate_hz = first_rate_hz,
                                   .last_rate_hz = last_rate_hz,
                                   .amplitude_px = amplitude_px,
                                   .noise_hz = noise_hz,
                                   .seed = whole_number("seed", seed)});
           }),
           py::kw_only(), py::arg("width"), py::arg("height"), py::arg("duration_us"),
           py::arg("t0_us"), py::arg("first_rate_hz"), py::arg("last_rate_hz"),
           py::arg("amplitude_px"), py::arg("noise_hz"), py::arg("seed"));

  py::class_<FlightOverChairs, EventStream>(m, "FlightOverChairsStream")
      .def(py::init([](std::int32_t width, std::int32_t height, std::int64_t duration_us,
                       std::int64_t t0_us, double last_rate_hz, double chair_px, double noise_hz,
                       const py::object& seed) {
             return FlightOverChairs({.width = width,
                                      .height = height,
                                      .duration = std::chrono::microseconds(duration_us),
                                      .start = std::chrono::microseconds(t0_us),
                                      .last_rate_hz = last_rate_hz,
                                      .chair_px = chair_px,
                                      .noise_hz = noise_hz,
                                      .seed = whole_number("seed", seed)});
           }),
           py::kw_only(), py::arg("width"), py::arg("height"), py::arg("duration_us"),
           py::arg("t0_us"), py::arg("last_rate_hz"), py::arg("chair_px"), py::arg("noise_hz"),
           py::arg("seed"));
}

}  // namespace asap::python::synthetic
