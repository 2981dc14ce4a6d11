// The extension asap._core: a table of contents. One file per layer of the C++ core, no logic.
#include <pybind11/pybind11.h>

#include "asap/version.hpp"
#include "gil.hpp"
#include "layers.hpp"
#include "refusals.hpp"

PYBIND11_MODULE(_core, m) {
  m.doc() = "Native core of asap.";
  m.attr("__version__") = std::string(asap::kVersion);

  asap::python::watch_exit_and_fork();
  asap::python::bind_filter(m);
  asap::python::bind_validator(m);
  asap::python::bind_schemes(m);
  asap::python::bind_telemetry(m);
  asap::python::bind_runner(m);
  asap::python::bind_pipeline(m);
  asap::python::bind_study(m);
  asap::python::bind_rivals(m);
  asap::python::bind_formats(m);
  asap::python::bind_synthetic(m);
  asap::python::bind_scenes(m);
  asap::python::bind_algorithms(m);
  asap::python::bind_rival_trackers(m);
  asap::python::bind_corners(m);
  asap::python::bind_hot_pixels(m);
  asap::python::bind_surfaces(m);
  asap::python::bind_flow(m);
  asap::python::bind_event_image(m);
  asap::python::bind_features(m);
  asap::python::refuse_in_words(m);
}
