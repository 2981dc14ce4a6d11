#include "consumer.hpp"

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/corner_detector.hpp"
#include "asap/algorithms/event_image.hpp"
#include "asap/algorithms/event_surface.hpp"
#include "asap/algorithms/feature_tracker.hpp"
#include "asap/algorithms/motion_segmenter.hpp"
#include "asap/algorithms/noise_filters.hpp"
#include "asap/algorithms/plane_flow.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "exact_type.hpp"
#include "gil.hpp"
#include "held.hpp"
#include "native_consumer.hpp"

namespace asap::python {
namespace {

// Destroyed with the consumer, which happens while the GIL is held.
struct PythonAlgorithm {
  py::object process;
  py::object set_gamma;
  PackageArrays arrays;
};

template <class Algorithm>
Consumer native(const py::object& algorithm) {
  return [ours = algorithm.cast<Held<Algorithm>>()](const Package& package) {
    const std::lock_guard turn(ours.turns());
    ours.has_worked() = true;
    ours->set_gamma(package.gamma);
    ours->process(package.events);
  };
}

// What passes goes nowhere: the filter is there to be timed.
template <class Filter>
Consumer native_filter(const py::object& algorithm) {
  return [ours = algorithm.cast<Held<Filter>>(),
          passed = std::vector<Event>()](const Package& package) mutable {
    const std::lock_guard turn(ours.turns());
    ours.has_worked() = true;
    ours->set_gamma(package.gamma);
    if (passed.size() < package.events.size()) passed.resize(package.events.size());
    ours->process(package.events, passed);
  };
}

template <class... Algorithms>
Consumer first_native(const py::object& algorithm) {
  Consumer consumer;
  ((is_exactly<Algorithms>(algorithm) && (consumer = native<Algorithms>(algorithm))) || ...);
  return consumer;
}

template <class... Filters>
Consumer first_native_filter(const py::object& algorithm) {
  Consumer consumer;
  ((is_exactly<Filters>(algorithm) && (consumer = native_filter<Filters>(algorithm))) || ...);
  return consumer;
}

// Empty: it is no algorithm of another extension.
Consumer foreign_native(const py::object& algorithm) {
  const py::object capsule = py::getattr(algorithm, kNativeConsumer, py::none());
  if (PyCapsule_IsValid(capsule.ptr(), kNativeConsumer) == 0) return {};
  const auto native =
      *static_cast<NativeConsumer*>(PyCapsule_GetPointer(capsule.ptr(), kNativeConsumer));
  return [native](const Package& package) {
    native.process(native.algorithm, package.events.data(), package.events.size(), package.gamma,
                   package.continues);
  };
}

// Empty: it has no native loop.
Consumer native_consumer_of(const py::object& algorithm) {
  if (Consumer consumer =
          first_native<ClusterTracker, PublishedClusterTracker, EFast, ArcStar, EHarris, FAHarris,
                       ThresholdOrdinalSurface, SpeedInvariantTimeSurface, PlaneFlow, EventImage,
                       FeatureTracker, MotionSegmenter>(algorithm)) {
    return consumer;
  }
  if (Consumer consumer = first_native_filter<BackgroundActivityFilter, HotPixelMask>(algorithm)) {
    return consumer;
  }
  return foreign_native(algorithm);
}

}  // namespace

bool is_native(const py::object& algorithm) {
  return static_cast<bool>(native_consumer_of(algorithm));
}

Consumer consumer_of(const py::object& algorithm, PackageArrays arrays) {
  if (algorithm.is_none()) return {};
  if (Consumer native = native_consumer_of(algorithm)) return native;
  const bool has_process = py::hasattr(algorithm, "process");
  if (!has_process && !PyCallable_Check(algorithm.ptr())) {
    throw py::type_error("algorithm: expected an object with process(events) or a callable, got " +
                         py::cast<std::string>(py::repr(algorithm)));
  }
  auto python = std::make_shared<PythonAlgorithm>();
  python->process = has_process ? algorithm.attr("process") : algorithm;
  python->set_gamma = py::getattr(algorithm, "set_gamma", py::none());
  python->arrays = std::move(arrays);
  return [python](const Package& package) {
    with_gil([&] {
      if (!python->set_gamma.is_none()) python->set_gamma(package.gamma);
      python->process(python->arrays.array_of(package.events));
    });
  };
}

}  // namespace asap::python
