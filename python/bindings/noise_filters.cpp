// The layer `algorithms`: BackgroundActivityFilter and HotPixelMask.
#include <pybind11/stl.h>

#include <utility>
#include <vector>

#include "arrays.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "gil.hpp"
#include "per_event.hpp"

namespace asap::python::noise_filters {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

constexpr const char* kBackgroundActivityFilterDoc = R"(Drops events without support.

An event passes if one of its eight neighbours, of either polarity, fired at most `window_us` before it.
Its own pixel does not count; a rejected event still supports others. Put it before whatever
discards events at random, which would remove the support.

$sensor.
window_us : int
    us, 0 to 500 000 000; 1000 to 10 000 is usual.

$refuses

Notes
-----
A few nanoseconds per event. Threads take turns. A timestamp that goes back by up to 1 s counts as the latest one.
Source: Delbruck, "Frame-free dynamic digital vision", 2008.

$scene
>>> passed = asap.BackgroundActivityFilter(scene.width, scene.height).process(events)
>>> 0 < len(passed) < len(events)
True
)";

constexpr const char* kHotPixelsDoc = R"(Drops the events of hot pixels.

Which these are is given, learned from a recording with `learn`, or learned on the way, among each
`learn_events` events. A pixel is hot, as for `asap.check`, if it has at least 100 events, a thousandth of
all, and five times as many as the second busiest of the 24 pixels around it. Once masked it stays masked
until `reset`.

$sensor.
pixels : sequence of (x, y)
    Masked from the beginning, px; ``asap.check(source).hot_pixels[["x", "y"]].tolist()`` fits.
learn_events : int
    Events from which is learned on the way, again and again; up to 10^9. 0: never.

$refuses

Notes
-----
Threads take turns. Only pixels count, not timestamps and polarities. Three hot pixels within 2 px of each
other take each other for a moving edge: give them.

$scene
>>> mask = asap.HotPixelMask(scene.width, scene.height, pixels=[(27, 109)])
>>> passed = mask.process(events)
>>> mask.pixels
[(27, 109)]
)";

std::size_t learned(HotPixelMask& mask, const py::object& events) {
  const EventSpan span = as_span(events);
  return without_gil([&] { return mask.learn(span); });
}

Pairs pairs_of(const std::vector<MaskedPixel>& pixels) {
  Pairs pairs;
  for (const auto& [x, y] : pixels) pairs.emplace_back(x, y);
  return pairs;
}

Keyword<HotPixelMaskConfig> pixels() {
  return keyword<HotPixelMaskConfig>(
      "pixels",
      [](HotPixelMaskConfig& config, py::handle given) {
        try {
          config.pixels.clear();
          for (const auto& [x, y] : given.cast<Pairs>()) config.pixels.push_back({x, y});
        } catch (const py::cast_error&) {
          throw_wrong_kind("pixels", given, "give a sequence of (x, y)");
        }
      },
      [](const HotPixelMaskConfig& config) {
        return py::tuple(py::cast(pairs_of(config.pixels)));
      });
}

void bind_background_activity_filter(py::module_& m) {
  using Config = BackgroundActivityFilterConfig;
  Class<BackgroundActivityFilter> type(m, "BackgroundActivityFilter",
                                       documented(kBackgroundActivityFilterDoc).c_str());
  bind_passing(type);
  bind_rest(
      type, "background", sized<Config>({keyword("window_us", &Config::window)}),
      R"(Neighbours become as rare, so the window grows to window_us / gamma, at most 500 s. Tell nothing, or 1,
to a filter in front of the discarder.)");
}

void bind_hot_pixel_mask(py::module_& m) {
  using Config = HotPixelMaskConfig;
  Class<HotPixelMask> type(m, "HotPixelMask", documented(kHotPixelsDoc).c_str());
  bind_passing(type);
  type.def("learn", &learned, py::arg("events").noconvert(),
           R"(Masks the hot pixels of these events as well, judged by these events alone.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE
    Some seconds of a recording; a calm scene shows hot pixels best.

Returns
-------
int
    How many pixels of `events` are hot.

Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.
)")
      .def_property_readonly(
          "pixels", [](const HotPixelMask& self) { return pairs_of(self.pixels()); },
          "list of (x, y), px: the masked pixels, row by row.");
  bind_rest(type, "hot_pixels",
            sized<Config>({pixels(), keyword("learn_events", &Config::learn_events)}),
            "Checked, without effect: a hot pixel's share of all events stays what it is.");
}

void bind(py::module_& m) {
  bind_background_activity_filter(m);
  bind_hot_pixel_mask(m);
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::noise_filters
