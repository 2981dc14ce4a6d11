// A stub of Metavision's C++ interface: what the recipe of notebooks/board.md calls, in the same
// shape, to compile it without the driver. It has no camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace Metavision {

using timestamp = std::int64_t;
using CallbackId = std::size_t;

struct Event2d {
  unsigned short x;
  unsigned short y;
  short p;
  timestamp t;
};
struct EventCD : Event2d {};

class CD {
 public:
  CallbackId add_callback(const std::function<void(const EventCD*, const EventCD*)>& callback);
};

class Camera {
 public:
  static Camera from_first_available();
  CD& cd();
  bool start();
  bool is_running();
  bool stop();
};

}  // namespace Metavision
