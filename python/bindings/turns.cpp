#include "turns.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "gil.hpp"

namespace asap::python {
namespace {

constexpr auto kLook = std::chrono::microseconds(50);

struct Work {
  PyObject* object;
  unsigned long thread;
  std::uint64_t forks;  // a thread of the parent process does not come to its end here
};

std::vector<Work>& all() {
  static auto& works = *new std::vector<Work>;  // outlives every thread
  return works;
}

bool is_at_work_elsewhere(PyObject* object) {
  return std::ranges::any_of(all(), [&](const Work& work) {
    return work.object == object && work.thread != PyThread_get_thread_ident() &&
           work.forks == forks();
  });
}

}  // namespace

void wait_for_turn(py::handle object) {
  while (!all().empty() && !is_exiting() && is_at_work_elsewhere(object.ptr())) {
    const WithoutGil release;  // the other one needs it to come to its end
    std::this_thread::sleep_for(kLook);
  }
}

Turn::Turn(py::handle object) : object_(object) {
  wait_for_turn(object);
  all().push_back({object.ptr(), PyThread_get_thread_ident(), forks()});
}

Turn::~Turn() {
  const auto own = std::ranges::find_if(all(), [this](const Work& work) {
    return work.object == object_.ptr() && work.thread == PyThread_get_thread_ident();
  });
  if (own != all().end()) all().erase(own);
}

}  // namespace asap::python
