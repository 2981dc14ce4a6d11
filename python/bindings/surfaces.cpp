// The layer `algorithms`: the surfaces that events change around their pixel.
#include <utility>

#include "arrays.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "gil.hpp"
#include "layers.hpp"
#include "per_event.hpp"

namespace asap::python {
namespace {

constexpr const char* kThresholdOrdinalDoc = R"(How recently each pixel fired, in 8 bits (TOS).

Age is counted in events of the neighbourhood: an event takes 1 from every pixel of the `side` x `side`
window around it, to 0 what thereby falls below 255 - 2 `side`, and sets its own to 255. So edges are as
wide whatever their speed.

$sensor.
side : int
    px of the window, odd, 3 to 127.

$refuses

Notes
-----
Threads take turns. Only the order of the events matters, not stamps and polarities. Source: Glover,
Dinale, De Souza Rosa, Bamford, Bartolozzi, "luvHarris: A Practical Corner Detector for Event-Cameras",
TPAMI 2021. Public releases clear from one value lower.
)";

constexpr const char* kSpeedInvariantDoc = R"(The order in which neighbouring pixels fired (SITS).

Ranks go from (2 `radius` + 1)^2, the newest, down to 0. An event takes 1 from every pixel of the window
around it that ranks above its own, and sets its own to the top: the same picture at any speed.

$sensor.
radius : int
    px, 1 to 127; the window is 2 `radius` + 1 wide.

$refuses

Notes
-----
Threads take turns. Only the order of the events matters, not stamps and polarities. Source:
Manderscheid, Sironi, Bourdis, Migliore, Lepetit, "Speed Invariant Time Surface for Learning to Detect
Corner Points with Event-Based Cameras", CVPR 2019, with one surface for both polarities; two of them
keep polarities apart.
)";

template <class Surface>
void take(Surface& surface, const py::array& events) {
  const EventSpan span = as_span(events);
  // Pure C++ on memory that `events` keeps alive: other Python threads may run.
  const WithoutGil release;
  surface.process(span);
}

template <class Surface>
py::array_t<typename Surface::Value> values(const Surface& surface) {
  py::array_t<typename Surface::Value> copy({surface.config().height, surface.config().width});
  surface.copy_to({copy.mutable_data(), static_cast<std::size_t>(copy.size())});
  return copy;
}

template <class Surface>
void bind_surface(py::module_& m, const char* title, const char* doc, const char* name,
                  Keyword<typename Surface::Config> keyword, const char* surface_doc) {
  Class<Surface> type(m, title, documented(doc).c_str());
  bind_process(type, &take<Surface>, R"(Takes the next events of the stream.

$events

$not_events
)");
  type.def_property_readonly("surface", &values<Surface>, surface_doc);
  bind_rest(type, name, sized<typename Surface::Config>({std::move(keyword)}),
            R"(Tells the fraction of the events that reaches the surface, 0 <= gamma <= 1.

Checked, without effect: the published rule ages by the events around and holds no rate to correct.

$not_gamma
)");
}

}  // namespace

void bind_surfaces(py::module_& m) {
  bind_surface<ThresholdOrdinalSurface>(
      m, "ThresholdOrdinalSurface", kThresholdOrdinalDoc, "threshold_ordinal_surface",
      keyword("side", &ThresholdOrdinalSurfaceConfig::side),
      "ndarray of uint8, shape (height, width): a copy. 255: fired last; 0: long ago.");
  bind_surface<SpeedInvariantTimeSurface>(
      m, "SpeedInvariantTimeSurface", kSpeedInvariantDoc, "speed_invariant_time_surface",
      keyword("radius", &SpeedInvariantTimeSurfaceConfig::radius),
      "ndarray of uint16, shape (height, width): a copy. (2 radius + 1)^2: fired last.");
}

}  // namespace asap::python
