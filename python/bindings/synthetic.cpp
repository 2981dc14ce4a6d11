// The layer `synthetic`: streams of synthetic events, read once; asap.synthetic makes them
// iterable.
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "asap/synthetic/streams.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "keywords.hpp"

namespace asap::python::synthetic {
namespace {

py::array read_stream(EventStream& stream, const py::object& at_least) {
  const std::uint64_t count = whole_number("at_least", at_least);
  return moved_to_array(without_gil([&] { return read_events(stream, count); }));
}

template <class Stream, class Config>
void bind_stream(py::module_& m, const char* name, std::initializer_list<Keyword<Config>> more) {
  Keywords<Config> keywords(
      0, {keyword("width", &Config::width), keyword("height", &Config::height),
          keyword("duration_us", &Config::duration), keyword("t0_us", &Config::start),
          keyword("noise_hz", &Config::noise_hz), keyword("seed", &Config::seed)});
  for (const Row& row : more) keywords.rows.push_back(row);
  Class<Stream, EventStream> type(m, name);
  bind_constructor(type, keywords);
}

}  // namespace

void bind(py::module_& m) {
  Class<EventStream>(m, "EventStream", "Synthetic events, made as they are read, once.")
      .def("read", &read_stream, py::arg("at_least"),
           "A new array of at least so many events, fewer at the end, then empty.");

  using Pattern = ShakenPatternConfig;
  bind_stream<ShakenPattern, Pattern>(m, "ShakenPatternStream",
                                      {keyword("first_rate_hz", &Pattern::first_rate_hz),
                                       keyword("last_rate_hz", &Pattern::last_rate_hz),
                                       keyword("amplitude_px", &Pattern::amplitude_px)});
  using Flight = FlightOverChairsConfig;
  bind_stream<FlightOverChairs, Flight>(
      m, "FlightOverChairsStream",
      {keyword("last_rate_hz", &Flight::last_rate_hz), keyword("chair_px", &Flight::chair_px)});
}

}  // namespace asap::python::synthetic
