// Scenes with truth. A layout is a scene's configuration, a stream its events with their labels;
// asap_laboratory.scenes puts them together.
#include "study/scenes/scenes.hpp"

#include <pybind11/stl.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "arrays.hpp"
#include "gil.hpp"
#include "parts.hpp"
#include "study/scenes/large_scenes.hpp"

namespace asap::python {
namespace {

// Of shape (n,), both: events and their labels.
py::tuple read_scene(MovingShapes& stream, const py::object& at_least) {
  const std::uint64_t count = whole_number("at_least", at_least);
  std::vector<Event> events;
  std::vector<std::int32_t> labels;
  {
    const WithoutGil release;  // pure C++: other Python threads may run
    while (events.size() < count) {
      const EventSpan block = stream.next();
      if (block.empty()) break;
      events.insert(events.end(), block.begin(), block.end());
      labels.insert(labels.end(), stream.labels().begin(), stream.labels().end());
    }
  }
  return py::make_tuple(moved_to_array(std::move(events)), moved_to_array(std::move(labels)));
}

// Of shape (steps + 1, objects, 7): x, y, vx, vy, the direction of the object's x axis, its scale.
py::array track(const MovingShapesConfig& layout) {
  static_assert(sizeof(Pose) == 7 * sizeof(double));
  const std::vector<Pose> poses = without_gil([&] { return poses_of(layout); });
  const auto objects = static_cast<py::ssize_t>(objects_of(layout).size());
  const auto steps = static_cast<py::ssize_t>(layout.duration_us / MovingShapes::kStep_us + 1);
  py::array_t<double> values({steps, objects, py::ssize_t{7}});
  if (!poses.empty()) std::memcpy(values.mutable_data(), poses.data(), poses.size() * sizeof(Pose));
  return values;
}

// The corners of each object in its own frame, as an array (corners, 2); none of a disk or a ring.
py::list corners(const MovingShapesConfig& layout) {
  py::list all;
  for (const MovingShape& shape : objects_of(layout)) {
    const RigidShape outline{shape.kind, shape.radius_px, shape.thickness_px};
    const auto size = static_cast<py::ssize_t>(outline.vertices().size());
    py::array_t<double> points({size, py::ssize_t{2}});
    auto cells = points.mutable_unchecked<2>();
    for (py::ssize_t i = 0; i < size; ++i) {
      cells(i, 0) = outline.vertices()[static_cast<std::size_t>(i)].x;
      cells(i, 1) = outline.vertices()[static_cast<std::size_t>(i)].y;
    }
    all.append(points);
  }
  return all;
}

std::vector<double> reaches_px(const MovingShapesConfig& layout) {
  std::vector<double> reaches;
  for (const MovingShape& shape : objects_of(layout)) reaches.push_back(reach_px(shape));
  return reaches;
}

MovingShapesConfig scene_named(const std::string& name, const py::object& seed) {
  return scenes::named(name.size() == 1 ? name[0] : '?', whole_number("seed", seed));
}

MovingShapesConfig free_shapes(std::int32_t count, std::int32_t width, std::int32_t height,
                               std::int64_t duration_us, std::pair<double, double> radius_px,
                               std::pair<double, double> speed_px_s, double noise_hz,
                               const py::object& seed) {
  return scenes::free_shapes({.count = count,
                              .width = width,
                              .height = height,
                              .duration_us = duration_us,
                              .radius_px{radius_px.first, radius_px.second},
                              .speed_px_s{speed_px_s.first, speed_px_s.second},
                              .noise_hz = noise_hz,
                              .seed = whole_number("seed", seed)});
}

// A list of the kinds' names, in turn.
MovingShapesConfig large_shapes(const std::vector<std::string>& kinds, const py::object& seed) {
  constexpr std::pair<std::string_view, ShapeKind> kKinds[] = {
      {"bars", ShapeKind::kBar}, {"angles", ShapeKind::kAngle}, {"rings", ShapeKind::kRing}};
  std::vector<ShapeKind> found;
  for (const std::string& name : kinds) {
    for (const auto& [known, kind] : kKinds) {
      if (name == known) found.push_back(kind);
    }
  }
  return scenes::large_shapes(found, whole_number("seed", seed));
}

template <MovingShapesConfig (*make)(std::uint64_t)>
MovingShapesConfig seeded(const py::object& seed) {
  return make(whole_number("seed", seed));
}

template <class Scene, MovingShapesConfig (*make)(const Scene&)>
MovingShapesConfig scripted(std::int64_t gap_us, double speed_px_s, double radius_px,
                            double noise_hz, const py::object& seed) {
  return make({.gap_us = gap_us,
               .speed_px_s = speed_px_s,
               .radius_px = radius_px,
               .noise_hz = noise_hz,
               .seed = whole_number("seed", seed)});
}

}  // namespace

void bind_scenes(py::module_& m) {
  py::class_<MovingShapesConfig>(m, "SceneLayout", "What moves how, and in which view.")
      .def_static("named", &scene_named, py::arg("name"), py::arg("seed"))
      .def_static("free_shapes", &free_shapes, py::kw_only(), py::arg("count"), py::arg("width"),
                  py::arg("height"), py::arg("duration_us"), py::arg("radius_px"),
                  py::arg("speed_px_s"), py::arg("noise_hz"), py::arg("seed"))
      .def_static("large_shapes", &large_shapes, py::kw_only(), py::arg("kinds"), py::arg("seed"))
      .def_static("large_disks", &seeded<scenes::large_disks>, py::kw_only(), py::arg("seed"))
      .def_static("hands", &seeded<scenes::hands>, py::kw_only(), py::arg("seed"))
      .def_static("moving_camera", &seeded<scenes::moving_camera>, py::kw_only(), py::arg("seed"))
      .def_static("sparse", &seeded<scenes::sparse>, py::kw_only(), py::arg("seed"))
      .def_static("approaching", &seeded<scenes::approaching>, py::kw_only(), py::arg("seed"))
      .def_static("lamps", &seeded<scenes::lamps>, py::kw_only(), py::arg("seed"))
      .def_static("fence", &seeded<scenes::fence>, py::kw_only(), py::arg("seed"))
      .def_static("stop_and_go", &scripted<scenes::StopAndGo, scenes::stop_and_go>, py::kw_only(),
                  py::arg("gap_us"), py::arg("speed_px_s"), py::arg("radius_px"),
                  py::arg("noise_hz"), py::arg("seed"))
      .def_static("occlusion", &scripted<scenes::Occlusion, scenes::occlusion>, py::kw_only(),
                  py::arg("gap_us"), py::arg("speed_px_s"), py::arg("radius_px"),
                  py::arg("noise_hz"), py::arg("seed"))
      .def_readonly("width", &MovingShapesConfig::width)
      .def_readonly("height", &MovingShapesConfig::height)
      .def_readonly("duration_us", &MovingShapesConfig::duration_us)
      .def_property_readonly("reaches_px", &reaches_px,
                             "How far each object gets from its centre at the start.")
      .def("corners", &corners, "Of each object, in its own frame: (n, 2), px.")
      .def("track", &track, "(steps + 1, objects, 7): x, y, vx, vy, axis x, axis y, scale.");

  py::class_<MovingShapes>(m, "MovingShapesStream", "The events of a layout, read once.")
      .def(py::init<const MovingShapesConfig&>(), py::arg("layout"))
      .def("read", &read_scene, py::arg("at_least"),
           "New arrays of at least so many events and their labels, fewer at the end, then empty.");
}

}  // namespace asap::python
