#include "machine.hpp"

namespace asap {
namespace simulation {
namespace {

thread_local Machine* machine = nullptr;

}  // namespace

Machine::Machine() noexcept { machine = this; }
Machine::~Machine() { machine = nullptr; }

}  // namespace simulation

// Instead of the library's.
System::Clock::time_point System::now() noexcept { return simulation::machine->now(); }
void System::sleep(Word& word, Clock::time_point deadline) noexcept {
  simulation::machine->sleep(word, deadline);
}
void System::wake(Word& word) noexcept { simulation::machine->wake(word); }

}  // namespace asap
