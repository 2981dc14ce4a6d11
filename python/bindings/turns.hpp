// Turns at an object: its process() works without the GIL, so another thread's call of the same
// object waits here until that one is done. Never in a circle: such a process() calls no Python.
// With the GIL; while no process() is at work a look at an empty list.
#pragma once

#include <pybind11/pybind11.h>

namespace asap::python {

// Waits until no other thread is at work with the object.
void wait_for_turn(pybind11::handle object);

// While it lives this thread is at work with the object.
class Turn {
 public:
  explicit Turn(pybind11::handle object);
  ~Turn();
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  pybind11::handle object_;
};

}  // namespace asap::python
