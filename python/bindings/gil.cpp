#include "gil.hpp"

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace asap::python {
namespace {

constexpr auto kMaxPatience = std::chrono::milliseconds(450);
constexpr auto kLook = std::chrono::milliseconds(1);

// Sequentially consistent: who comes back says so and then looks whether the interpreter is gone;
// the hook says that it is gone and then looks who comes back.
struct Border {
  std::atomic<int> away{0};
  std::atomic<int> coming_back{0};
  std::atomic<bool> exiting{false};
  std::atomic<bool> gone{false};
  std::atomic<std::uint64_t> forks{0};
};
Border border;

std::vector<std::function<void()>>& stops() {
  static auto& all = *new std::vector<std::function<void()>>;  // outlives every thread
  return all;
}

template <class Take>
void come_back(Take take) {
  ++border.coming_back;
  if (border.gone) {
    --border.coming_back;
    sleep_until_the_end();
  }
  take();
  --border.coming_back;
}

void wait_until_none(const std::atomic<int>& is, std::chrono::steady_clock::time_point deadline) {
  while (is > 0 && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(kLook);
}

void leave() {
  if (border.exiting.exchange(true)) return;  // registered again, after an import that failed
  const py::gil_scoped_release release;
  const auto deadline = std::chrono::steady_clock::now() + kMaxPatience;
  for (const auto& stop : stops()) stop();
  wait_until_none(border.away, deadline);
  border.gone = true;
  wait_until_none(border.coming_back, deadline + kMaxPatience / 10);
}

// Only this thread lives on in the child.
[[maybe_unused]] void become_child() {
  border.away = 0;
  border.coming_back = 0;
  ++border.forks;
}

}  // namespace

bool is_exiting() noexcept { return border.exiting; }
std::uint64_t forks() noexcept { return border.forks.load(std::memory_order_relaxed); }

WithoutGil::WithoutGil() : forks_(forks()) {
  if (border.exiting) return;
  ++border.away;
  release_.emplace();
}

WithoutGil::~WithoutGil() {
  if (!release_) return;
  come_back([this] { release_.reset(); });
  if (forks_ == forks()) --border.away;
}

WithGil::WithGil() {
  if (PyGILState_Check() == 1) return;
  come_back([this] { acquire_.emplace(); });
}

void sleep_until_the_end() noexcept {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

void check_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void on_exit(std::function<void()> stop) { stops().push_back(std::move(stop)); }

void watch_exit_and_fork() {
#if defined(__unix__) || defined(__APPLE__)
  pthread_atfork(nullptr, nullptr, become_child);
#endif
  py::module_::import("atexit").attr("register")(py::cpp_function(&leave));
}

}  // namespace asap::python
