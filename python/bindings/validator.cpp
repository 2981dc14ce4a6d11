// The layer `filter`: Validator.
#include "asap/filter/validator.hpp"

#include "arrays.hpp"
#include "filter/stray_stamps.hpp"
#include "gil.hpp"
#include "keywords.hpp"
#include "telemetry.hpp"

namespace asap::python::validator {

namespace {

constexpr Choices<OnBad, 3> kOnBad{
    {{"drop", OnBad::drop}, {"clamp", OnBad::clamp}, {"raise", OnBad::raise}}};

py::array array_of(Checked&& checked, const py::array& events) {
  if (checked.untouched) return events;
  return moved_to_array(std::move(checked.kept));
}

// The array itself where all of it is good, else what is left of it.
py::array check(Validator& validator, const py::array& events) {
  const EventSpan all = as_span(events);
  return array_of(without_gil([&] { return check_all(validator, all); }), events);
}

// The same, and the number of events that were stray.
py::tuple check_recorded(Validator& validator, const py::array& events) {
  const EventSpan all = as_span(events);
  Checked checked = without_gil([&] { return asap::check_recorded(validator, all); });
  const std::size_t stray = checked.stray;
  return py::make_tuple(array_of(std::move(checked), events), stray);
}

py::dict repaired(const Validator& validator) {
  using namespace py::literals;
  const Repairs& by = validator.repaired();
  return py::dict("normalised_polarity"_a = by.normalised_polarity,
                  "lifted_stamps"_a = by.lifted_stamps,
                  "clamped_positions"_a = by.clamped_positions);
}

}  // namespace

void bind(py::module_& m) {
  Class<Validator>(m, "Validator")
      .def(
          py::init([](const py::object& width, const py::object& height, const py::object& on_bad,
                      const py::object& reorder_tolerance_us, const py::object& warmup_discard_us) {
            return Validator({.width = whole_number<int>("width", width),
                              .height = whole_number<int>("height", height),
                              .on_bad = chosen(kOnBad, "on_bad", on_bad),
                              .reorder_tolerance = std::chrono::microseconds(
                                  whole_number<int>("reorder_tolerance_us", reorder_tolerance_us)),
                              .warmup_discard = std::chrono::microseconds(
                                  whole_number<int>("warmup_discard_us", warmup_discard_us))});
          }),
          py::kw_only(), py::arg("width") = 0, py::arg("height") = 0, py::arg("on_bad") = "drop",
          py::arg("reorder_tolerance_us") = 0, py::arg("warmup_discard_us") = 0)
      .def("check", &check, py::arg("events").noconvert())
      .def("check_recorded", &check_recorded, py::arg("events").noconvert())
      .def_property_readonly("received", &Validator::received)
      .def_property_readonly("rejected",
                             [](const Validator& self) { return dict_of(self.rejected()); })
      .def_property_readonly("repaired", &repaired)
      .def_property_readonly("last_us", &Validator::last_us)
      .def_property_readonly("clock_resets", &Validator::clock_resets);
}

}  // namespace asap::python::validator
