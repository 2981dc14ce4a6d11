// The extension asap._core: a table of contents. One file per layer of the C++ core, no logic but
// how it begins.
#include <pybind11/pybind11.h>

#include "asap/version.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "layers.hpp"

namespace {

// Types stay registered, with NumPy too, whatever becomes of the import: what may take long, and so
// be interrupted, comes before them.
void begin_once() {
  static bool has_begun = false;
  pybind11::module_::import("numpy");
  asap::python::watch_exit_and_fork();
  if (has_begun) {
    throw pybind11::import_error(
        "asap: an import in this process did not come to its end; start Python anew");
  }
  has_begun = true;
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "Native core of asap.";
  m.attr("__version__") = std::string(asap::kVersion);

  begin_once();
  asap::python::bind_filter(m);
  asap::python::bind_validator(m);
  asap::python::bind_schemes(m);
  asap::python::bind_telemetry(m);
  asap::python::bind_runner(m);
  asap::python::bind_pipeline(m);
  asap::python::bind_oracle(m);
  asap::python::bind_formats(m);
  asap::python::bind_columns(m);
  asap::python::bind_decoders(m);
  asap::python::bind_synthetic(m);
  asap::python::bind_cluster_trackers(m);
  asap::python::bind_corners(m);
  asap::python::bind_hot_pixels(m);
  asap::python::bind_surfaces(m);
  asap::python::bind_flow(m);
  asap::python::bind_event_image(m);
  asap::python::bind_features(m);
  asap::python::bind_motion(m);
  asap::python::close_classes(m);
}
