// Poisson arrivals of any rate: what asap_laboratory.profiles is made of.
#include <cstddef>
#include <cstdint>

#include "arguments.hpp"
#include "arrays.hpp"
#include "held.hpp"
#include "parts.hpp"
#include "study/poisson_arrivals.hpp"

namespace asap::python {
namespace {

void feed(PoissonArrivals& arrivals, const py::array& rates_hz) {
  using Rates = py::array_t<double, py::array::c_style>;
  if (!Rates::check_(rates_hz) || rates_hz.ndim() != 1) {
    throw py::type_error("rates_hz: give a contiguous array of shape (n,) and dtype float64");
  }
  arrivals.feed(
      {static_cast<const double*>(rates_hz.data()), static_cast<std::size_t>(rates_hz.size())});
}

}  // namespace

void bind_arrivals(py::module_& m) {
  Class<PoissonArrivals, EventStream>(m, "PoissonArrivals",
                                      "Ends where its rates end; feed() makes it go on.")
      .def(py::init([](std::int32_t width, std::int32_t height, std::int64_t duration_us,
                       std::int64_t t0_us, double noise, const py::object& seed) {
             return PoissonArrivals({.width = width,
                                     .height = height,
                                     .duration = std::chrono::microseconds(duration_us),
                                     .start = std::chrono::microseconds(t0_us),
                                     .noise = noise,
                                     .seed = whole_number("seed", seed)});
           }),
           py::kw_only(), py::arg("width"), py::arg("height"), py::arg("duration_us"),
           py::arg("t0_us"), py::arg("noise"), py::arg("seed"))
      .def("feed", &feed, py::arg("rates_hz"),
           "Rates of the next steps of 0.1 ms, events per second; a float64 array of shape (n,).");
}

}  // namespace asap::python
