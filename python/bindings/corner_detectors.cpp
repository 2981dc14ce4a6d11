// The layer `algorithms`: the corner detectors.
#include <cstdint>
#include <initializer_list>

#include "arrays.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "per_event.hpp"

namespace asap::python::corner_detectors {
namespace {

constexpr const char* kEFastDoc = R"(Finds corners by the order of the events alone.

An event is a corner if on a circle of 16 pixels around it 3 to 6 neighbouring ones fired later than all
others, and 4 to 8 on a circle of 20, counting the latest event of its polarity at each pixel.

$sensor; those within
    4 px of the border are never corners.

$refuses

Notes
-----
Threads take turns. A timestamp that goes back by up to 1 s counts as the latest one. Source: Mueggler, Bartolozzi,
Scaramuzza, "Fast Event-based Corner Detection", BMVC 2017. The authors' release swaps the sides of its
surface, which changes some labels where width is not height; here they are as published.

$scene
>>> corners = events[asap.EFast(scene.width, scene.height).process(events)]
>>> 0 < len(corners) < len(events)
True
)";

constexpr const char* kArcStarDoc = R"(Finds corners by the length of the newest arc.

Only events are tested whose pixel was silent for `filter_us` in their polarity, or fired in the other
since. Such an event is a corner if on a circle of 16 pixels around it the newest arc has at most 6 or 10
to 13 of them, and on a circle of 20 at most 8 or 12 to 16.

$sensor; those within
    4 px of the border are never corners.
filter_us : int
    us, 0 to 500 000 000.

$refuses

Notes
-----
Threads take turns. A timestamp that goes back by up to 1 s counts as the latest one. A pixel without an event counts as
fired at time 0, as in the authors' release, or just before the first timestamp if that is negative. Source:
Alzugaray, Chli, "Asynchronous Corner Detection and Tracking for Event Cameras in Real Time", RA-L 2018.

$scene
>>> corners = events[asap.ArcStar(scene.width, scene.height).process(events)]
>>> 0 < len(corners) < len(events)
True
)";

constexpr const char* kEHarrisDoc = R"(Finds corners by the Harris score of the newest pixels.

The 25 pixels of the 9 x 9 window around an event that fired last, in its polarity, are a black and white
patch. The event is a corner if there are 25 and the Harris score of the patch exceeds `threshold`.

$sensor; those within
    4 px of the left and upper border, or 3 px of the others, are never corners.
threshold : float
    Least score of a corner.

$refuses

Notes
-----
Threads take turns. Only the order of the events matters, not their timestamps. Source: Vasco, Glover,
Bartolozzi, "Fast Event-based Harris Corner Detection Exploiting the Advantages of Event-driven Cameras",
IROS 2016, with the constants of the public implementation.

$scene
>>> corners = events[asap.EHarris(scene.width, scene.height).process(events)]
>>> 0 < len(corners) < len(events)
True
)";

constexpr const char* kFAHarrisDoc =
    R"(Finds corners in two steps: the arcs of ArcStar propose, the Harris score decides.

Both steps look only at events that pass the filter of ArcStar. The score is that of EHarris.

$sensor; those within
    4 px of the border are ignored altogether.
filter_us : int
    us, 0 to 500 000 000.
threshold : float
    Least score of a corner.

$refuses

Notes
-----
Threads take turns. A timestamp that goes back by up to 1 s counts as the latest one. Source: Li, Shi, Zhang, Li, Liu,
"FA-Harris: A Fast and Asynchronous Corner Detector for Event Cameras", IROS 2019, with the constants of
its release; equal timestamps, undefined there, are ordered by arrival.

$scene
>>> corners = events[asap.FAHarris(scene.width, scene.height).process(events)]
>>> 0 < len(corners) < len(events)
True
)";

template <class Detector>
void bind_detector(py::module_& m, const char* title, const char* doc, const char* name,
                   std::initializer_list<Keyword<typename Detector::Config>> keywords = {}) {
  Class<Detector> type(m, title, documented(doc).c_str());
  bind_answering<bool, std::uint8_t>(type,
                                     R"(ndarray of bool, shape (n,)
    True where the event is a corner.)");
  bind_rest(type, name, sized<typename Detector::Config>(keywords),
            "Checked, without effect: the published rule holds no rate that could be corrected.");
}

void bind(py::module_& m) {
  bind_detector<EFast>(m, "EFast", kEFastDoc, "e_fast");
  bind_detector<ArcStar>(m, "ArcStar", kArcStarDoc, "arc_star",
                         {keyword("filter_us", &ArcStarConfig::filter)});
  bind_detector<EHarris>(m, "EHarris", kEHarrisDoc, "e_harris",
                         {keyword("threshold", &EHarrisConfig::threshold)});
  bind_detector<FAHarris>(m, "FAHarris", kFAHarrisDoc, "fa_harris",
                          {keyword("filter_us", &FAHarrisConfig::filter),
                           keyword("threshold", &FAHarrisConfig::threshold)});
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::corner_detectors
