// Machine: what this program puts in the place of the operating system (runner/system.hpp): while
// one lives, it is the machine of its thread.
#pragma once

#include "runner/system.hpp"

namespace asap::simulation {

class Machine {
 public:
  using Time = System::Clock::time_point;

  virtual Time now() noexcept = 0;
  virtual void sleep(System::Word& word, Time deadline) noexcept = 0;
  virtual void wake(System::Word& word) noexcept = 0;

 protected:
  Machine() noexcept;
  ~Machine();
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;
};

}  // namespace asap::simulation
