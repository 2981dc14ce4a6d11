// The layer `algorithms`: EventImage.
#include <pybind11/stl.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "asap/algorithms/event_image.hpp"
#include "gil.hpp"
#include "per_event.hpp"

namespace asap::python::event_image {
namespace {

constexpr const char* kImageDoc = R"(Images of the events, one per so many events or per period.

They are the input of convolutional networks. By count an image ends with its last event. By period it holds
the timestamps from one multiple of the period to the next; a period without events gives no image.

$sensor.
count : int
    Events of an image, up to 16 777 216; or
period_us : int
    its duration, us of the sensor's clock, up to 10^12. One of the two is 0.
channels : sequence of str
    "off", "on": events of that polarity; "count": of both; "sum": ON minus OFF; "time": of the pixel's
    latest event, from 0 = begin to 1 = end of the image, 0 without one.

$refuses

Notes
-----
Threads take turns. A timestamp that goes back by up to 1 s counts as the latest one. Each image costs a pass over the
pixels. Channels as in Sanket et al., "EVDodgeNet", ICRA 2020, and Zhu et al., "EV-FlowNet", RSS 2018.

$scene
>>> images, spans = asap.EventImage(scene.width, scene.height, period_us=10_000).process(events)
>>> images.shape, spans.shape
((4, 2, 260, 346), (4, 2))
)";

constexpr Choices<ImageChannel, 5> kChannels{{{"off", ImageChannel::off},
                                              {"on", ImageChannel::on},
                                              {"count", ImageChannel::count},
                                              {"sum", ImageChannel::sum},
                                              {"time", ImageChannel::time}}};

Keyword<EventImageConfig> channels() {
  return keyword<EventImageConfig>(
      "channels",
      [](EventImageConfig& config, py::handle given) {
        if (!py::isinstance<py::sequence>(given) || py::isinstance<py::str>(given)) {
          throw_wrong_kind("channels", given, "give a sequence of names");
        }
        config.channels.clear();
        for (const py::handle name : given) {
          config.channels.push_back(chosen(kChannels, "channels", name));
        }
      },
      [](const EventImageConfig& config) {
        py::list names;
        for (const ImageChannel channel : config.channels) {
          names.append(name_in(kChannels, channel));
        }
        return py::tuple(names);
      });
}

template <class Value>
py::array reshaped(std::vector<Value> values, std::vector<py::ssize_t> shape) {
  return moved_to_array(std::move(values)).attr("reshape")(shape);
}

std::vector<py::ssize_t> shape_of(const EventImageConfig& config, std::size_t images) {
  return {static_cast<py::ssize_t>(images), static_cast<py::ssize_t>(config.channels.size()),
          config.height, config.width};
}

py::tuple images(EventImage& image, const py::object& events) {
  const EventSpan span = as_span(events);
  std::vector<float> values;
  std::vector<std::int64_t> times_us;
  const std::size_t complete = without_gil([&] {
    return image.process(span, [&](const ImageView& view) {
      values.insert(values.end(), view.values.begin(), view.values.end());
      times_us.insert(times_us.end(), {view.begin_us, view.end_us});
    });
  });
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

void bind(py::module_& m) {
  using Config = EventImageConfig;
  Class<EventImage> type(m, "EventImage", documented(kImageDoc).c_str());
  bind_process(type, &images,
               R"(images : ndarray of float32, shape (k, channels, height, width)
spans : ndarray of int64, shape (k, 2)
    us: begin of each image, and its end, which is the first timestamp beyond.)");
  type.def("flush", &EventImage::flush,
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
  bind_rest(type, "event_image",
            sized<Config>({keyword("count", &Config::count), keyword("period_us", &Config::period),
                           channels()}),
            R"(Every event then stands for 1 / gamma, at most 1000: images end as often as without a
discarder, and hold as much on average.)");
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::event_image
