#include "per_event.hpp"

namespace asap::python {

std::string documented(std::string text) {
  constexpr std::pair<const char*, const char*> kTexts[] = {
      {"$sensor", R"(Parameters
----------
width, height : int
    Size of the sensor, px, 1 to 16384. Events outside are dropped and counted in `rejected`)"},
      {"$refuses", R"(Raises
------
ValueError
    A parameter is out of range; the message names it.)"},
      {"$events", R"(Parameters
----------
events : ndarray of shape (n,) in EVENT_DTYPE)"},
      {"$not_events", R"(Raises
------
TypeError
    `events` is not a contiguous array in EVENT_DTYPE; convert with asap.as_events.)"},
      {"$outline", R"(Returns
-------
numpy.void
    A row with the float64 fields x, y (px, centre), major, minor (px, half-axes) and angle (rad, of the
    major axis, from x to the right towards y downwards, -pi/2 to pi/2).

Raises
------
KeyError
    There is no such id now.)"},
      {"$not_gamma", R"(Raises
------
ValueError
    gamma is NaN or outside [0, 1].)"},
  };
  for (const auto& [word, meaning] : kTexts) {
    const std::size_t at = text.find(word);
    if (at != std::string::npos) text.replace(at, std::string(word).size(), meaning);
  }
  return text;
}

}  // namespace asap::python
