// Turns at an object that is worked with natively, without the GIL: by its own process(), or by a
// runner that it was given to, package by package. Who calls it from another thread meanwhile comes
// in between, in the order of asking, and finds it as the last package has left it.
//
// Never in a circle: who works natively calls no Python while it is its turn.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

namespace asap::python {

// A mutex by which who comes first is served first: another one would let a runner that is never
// idle pass a reader for ever. lock() without the GIL.
class Turns {
 public:
  bool try_lock() noexcept;
  void lock() noexcept;
  void unlock() noexcept;
  bool are_mine() const noexcept { return owner_ == std::this_thread::get_id(); }

 private:
  std::atomic<std::uint32_t> next_{0};
  std::atomic<std::uint32_t> serving_{0};
  std::atomic<std::thread::id> owner_{};
};

// Of that object: found, or made for as long as somebody holds them. With the GIL.
std::shared_ptr<Turns> turns_at(pybind11::handle object);

// Null: nobody works with it natively. With the GIL.
std::shared_ptr<Turns> turns_under_way_at(pybind11::handle object);

// Whether there have been turns at it since it was made: its parameters no longer say all of it.
// With the GIL.
bool has_worked(pybind11::handle object);

// While it lives it is this thread's turn, a caller's from Python: taken with the GIL, which is let
// go while another one has it. None if `turns` is null, if this thread has it already, or at exit.
class CallersTurn {
 public:
  explicit CallersTurn(std::shared_ptr<Turns> turns);
  ~CallersTurn();
  CallersTurn(const CallersTurn&) = delete;
  CallersTurn& operator=(const CallersTurn&) = delete;

 private:
  std::shared_ptr<Turns> turns_;
};

}  // namespace asap::python
