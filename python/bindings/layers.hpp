// The bind functions of the layers, in the order of the include graph.
#pragma once

#include <pybind11/pybind11.h>

namespace asap::python {

void bind_filter(pybind11::module_& m);
void bind_validator(pybind11::module_& m);
void bind_schemes(pybind11::module_& m);
void bind_telemetry(pybind11::module_& m);
void bind_runner(pybind11::module_& m);
void bind_pipeline(pybind11::module_& m);
void bind_oracle(pybind11::module_& m);
void bind_formats(pybind11::module_& m);
void bind_columns(pybind11::module_& m);
void bind_decoders(pybind11::module_& m);
void bind_synthetic(pybind11::module_& m);
void bind_cluster_trackers(pybind11::module_& m);
void bind_corners(pybind11::module_& m);
void bind_hot_pixels(pybind11::module_& m);
void bind_surfaces(pybind11::module_& m);
void bind_flow(pybind11::module_& m);
void bind_event_image(pybind11::module_& m);
void bind_features(pybind11::module_& m);
void bind_motion(pybind11::module_& m);

}  // namespace asap::python
