// The layer `algorithms`: the surfaces that events change around their pixel.
#include "arrays.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "per_event.hpp"

namespace asap::python::surfaces {
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
Threads take turns. Only the order of the events matters, not timestamps and polarities. Source: Glover,
Dinale, De Souza Rosa, Bamford, Bartolozzi, "luvHarris: A Practical Corner Detector for Event-Cameras",
TPAMI 2021. Public releases clear from one value lower.

$scene
>>> tos = asap.ThresholdOrdinalSurface(scene.width, scene.height, side=7)
>>> tos.process(events)
>>> tos.surface.shape, tos.surface.dtype
((260, 346), dtype('uint8'))
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
Threads take turns. Only the order of the events matters, not timestamps and polarities. Source:
Manderscheid, Sironi, Bourdis, Migliore, Lepetit, "Speed Invariant Time Surface for Learning to Detect
Corner Points with Event-Based Cameras", CVPR 2019, with one surface for both polarities; two of them
keep polarities apart.

$scene
>>> sits = asap.SpeedInvariantTimeSurface(scene.width, scene.height, radius=6)
>>> sits.process(events)
>>> sits.surface.shape, sits.surface.dtype
((260, 346), dtype('uint16'))
)";

template <class Surface>
void bind_surface(py::module_& m, const char* title, const char* doc, const char* name,
                  Keyword<typename Surface::Config> keyword, const char* surface_doc) {
  Class<Surface> type(m, title, documented(doc).c_str());
  bind_taking(type);
  type.def_property_readonly("surface", &copied<typename Surface::Value, Surface>, surface_doc);
  bind_rest(type, name, sized<typename Surface::Config>({keyword}),
            "Checked, without effect: the published rule ages by the events around and holds no "
            "rate to correct.");
}

void bind(py::module_& m) {
  bind_surface<ThresholdOrdinalSurface>(
      m, "ThresholdOrdinalSurface", kThresholdOrdinalDoc, "tos",
      keyword("side", &ThresholdOrdinalSurfaceConfig::side),
      "ndarray of uint8, shape (height, width): a copy. 255: fired last; 0: long ago.");
  bind_surface<SpeedInvariantTimeSurface>(
      m, "SpeedInvariantTimeSurface", kSpeedInvariantDoc, "sits",
      keyword("radius", &SpeedInvariantTimeSurfaceConfig::radius),
      "ndarray of uint16, shape (height, width): a copy. (2 radius + 1)^2: fired last.");
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::surfaces
