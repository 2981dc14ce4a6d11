// The layer `filter`: GammaFilter.
#include "asap/filter/gamma_filter.hpp"

#include "arrays.hpp"
#include "gil.hpp"
#include "keywords.hpp"

namespace asap::python::gamma_filter {
namespace {

constexpr const char* kGammaFilterDoc = R"(Keeps each event with probability gamma, reproducibly.

Whether event number i is kept depends on (seed, i, gamma) alone: not on how the stream is cut into
arrays. A smaller gamma keeps a subset. The gamma filter of ASAP (Tapia et al., 2020).

Parameters
----------
seed : int
    0 <= seed < 2**64.

Raises
------
ValueError
    The seed or, in a call, gamma is out of range.

Examples
--------
>>> events = asap.synthetic.FlightOverChairs(duration_s=0.1).events()
>>> kept = asap.GammaFilter().apply(events, 0.5)  # a new array in EVENT_DTYPE
>>> round(len(kept) / len(events), 1)
0.5
)";

struct GammaFilterConfig {
  std::uint64_t seed = 0;
};

// With the seed that it was made of, which its random numbers do not tell.
class SeededFilter : public GammaFilter {
 public:
  explicit SeededFilter(const GammaFilterConfig& config)
      : GammaFilter(config.seed), config_(config) {}

  const GammaFilterConfig& config() const noexcept { return config_; }

 private:
  GammaFilterConfig config_;
};

py::array apply(SeededFilter& filter, const py::object& events, double gamma) {
  const EventSpan span = as_span(events);
  const KeepThreshold threshold = KeepThreshold::checked(gamma);
  std::vector<Event> kept(span.size());
  kept.resize(without_gil([&] { return filter.apply(span, threshold, kept); }));
  return moved_to_array(std::move(kept));
}

py::array_t<bool> mask(SeededFilter& filter, const py::object& events, double gamma) {
  const EventSpan span = as_span(events);
  const KeepThreshold threshold = KeepThreshold::checked(gamma);
  py::array_t<bool> kept(static_cast<py::ssize_t>(span.size()));
  auto* bytes = reinterpret_cast<std::uint8_t*>(kept.mutable_data());
  without_gil([&] { filter.mask(span, threshold, {bytes, span.size()}); });
  return kept;
}

}  // namespace

void bind(py::module_& m) {
  Class<SeededFilter> type(m, "GammaFilter", kGammaFilterDoc);
  bind_configuration(type,
                     Keywords<GammaFilterConfig>(0, {keyword("seed", &GammaFilterConfig::seed)}));
  type.def("apply", &apply, py::arg("events").noconvert(), py::arg("gamma"),
           R"(The kept events, a new array of shape (k,) in EVENT_DTYPE.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE
gamma : float
    Probability that an event is kept, 0 <= gamma <= 1; 1 keeps all.

Raises
------
ValueError
    gamma is NaN or outside [0, 1]; the position does not move.
)")
      .def("mask", &mask, py::arg("events").noconvert(), py::arg("gamma"),
           "Like apply, but a bool array of shape (n,): True where the event is kept.")
      .def_property_readonly("position", &GammaFilter::position, "Events seen so far.");
}

}  // namespace asap::python::gamma_filter
