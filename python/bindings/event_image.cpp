// The layer `algorithms`: EventImage.
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "asap/algorithms/event_image.hpp"
#include "asap/core/check.hpp"
#include "gil.hpp"
#include "layers.hpp"
#include "per_event.hpp"

namespace asap::python {
namespace {

using namespace py::literals;

constexpr const char* kImageDoc = R"(Images of the events, one per so many events or per period.

What convolutional networks take. By count an image ends with its last event. By period it holds the stamps
from one multiple of the period to the next; a period without events gives no image.

Parameters
----------
width, height : int
    Size of the sensor, px, 1 to 16384. Events outside are dropped and counted in `rejected`.
count : int
    Events of an image, up to 16 777 216; or
period_us : int
    its duration, us of the sensor's clock, up to 10^12. One of the two is 0.
channels : sequence of str
    "off", "on": events of that polarity; "count": of both; "sum": ON minus OFF; "time": of the pixel's
    latest event, from 0 = begin to 1 = end of the image, 0 without one.

Raises
------
ValueError
    A parameter is out of range; the message names it.

Notes
-----
Threads take turns. A stamp that goes back counts as the latest one. Each image costs a pass over the
pixels. Channels as in Sanket et al., "EVDodgeNet", ICRA 2020, and Zhu et al., "EV-FlowNet", RSS 2018.
)";

constexpr std::array<std::string_view, 5> kChannels{"off", "on", "count", "sum", "time"};

ImageChannel channel_of(const std::string& name) {
  const auto* const found = std::find(kChannels.begin(), kChannels.end(), name);
  if (found == kChannels.end()) {
    throw_bad_value("channels", "'" + name + "'", "must be off, on, count, sum or time");
  }
  return static_cast<ImageChannel>(found - kChannels.begin());
}

py::dict parameters(const EventImageConfig& config) {
  py::list channels;
  for (const ImageChannel channel : config.channels) {
    channels.append(std::string(kChannels[static_cast<std::size_t>(channel)]));
  }
  return py::dict("count"_a = config.count, "period_us"_a = config.period_us,
                  "channels"_a = py::tuple(channels));
}

template <class Value>
py::array reshaped(std::vector<Value> values, std::vector<py::ssize_t> shape) {
  return moved_to_array(std::move(values)).attr("reshape")(shape);
}

std::vector<py::ssize_t> shape_of(const EventImageConfig& config, std::size_t images) {
  return {static_cast<py::ssize_t>(images), static_cast<py::ssize_t>(config.channels.size()),
          config.height, config.width};
}

py::tuple images(EventImage& image, const py::array& events) {
  const EventSpan span = as_span(events);
  std::vector<float> values;
  std::vector<std::int64_t> times_us;
  std::size_t complete = 0;
  {
    // Pure C++ on memory that `events` keeps alive: other Python threads may run.
    const WithoutGil release;
    complete = image.process(span, [&](const ImageView& view) {
      values.insert(values.end(), view.values.begin(), view.values.end());
      times_us.insert(times_us.end(), {view.begin_us, view.end_us});
    });
  }
  const auto count = static_cast<py::ssize_t>(complete);
  return py::make_tuple(reshaped(std::move(values), shape_of(image.config(), complete)),
                        reshaped(std::move(times_us), {count, 2}));
}

py::array last(const EventImage& image) {
  const auto values = image.image().values;
  auto shape = shape_of(image.config(), 1);
  shape.erase(shape.begin());
  return reshaped(std::vector<float>(values.begin(), values.end()), shape);
}

}  // namespace

void bind_event_image(py::module_& m) {
  py::class_<EventImage> type(m, "EventImage", kImageDoc);
  type.def(py::init([](int width, int height, std::int64_t count, std::int64_t period_us,
                       const std::vector<std::string>& channels) {
             EventImageConfig config{.width = width,
                                     .height = height,
                                     .count = count,
                                     .period_us = period_us,
                                     .channels = {}};
             for (const std::string& name : channels) config.channels.push_back(channel_of(name));
             return std::make_unique<EventImage>(config);
           }),
           "width"_a, "height"_a, py::kw_only(), "count"_a = 0, "period_us"_a = 0,
           "channels"_a = py::make_tuple("off", "on"))
      .def("process", &images, py::arg("events").noconvert(),
           R"(Takes the next events of the stream and returns the images that they complete.

Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE

Returns
-------
images : ndarray of float32, shape (k, channels, height, width)
spans : ndarray of int64, shape (k, 2)
    us: begin of each image, and its end, which is the first stamp beyond.

Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.
)")
      .def("flush", &EventImage::flush,
           R"(Completes the image that has begun, which is then `image`.

Returns
-------
bool
    False if none has begun.
)")
      .def_property_readonly("image", &last,
                             "ndarray of float32, shape (channels, height, width): a copy of the "
                             "last complete image; zeros before the first.")
      .def_property_readonly(
          "span",
          [](const EventImage& self) {
            return std::pair(self.image().begin_us, self.image().end_us);
          },
          "Begin and end of `image`, us.");
  bind_rest(type, "event_image", &parameters,
            R"(Tells the fraction of the events that reaches the images, 0 <= gamma <= 1.

Every event then stands for 1 / gamma, at most 1000: images end as often as without a discarder, and hold
as much on average.

Raises
------
ValueError
    gamma is NaN or outside [0, 1].
)");
}

}  // namespace asap::python
