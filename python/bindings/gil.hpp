// The border between Python and native code: how threads cross it so that neither the end of the
// interpreter nor a fork catches them on the way.
//
// A thread that asks for the GIL of an interpreter that is ending is ended by it (before 3.14), by
// an unwinding that no destructor lets through: std::terminate. So a hook of atexit ends what waits
// (on_exit), waits for a while until no thread is away; one that comes back later sleeps for ever.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <functional>
#include <optional>

#if __has_include(<cxxabi.h>)
#include <cxxabi.h>
#endif

namespace asap::python {

namespace py = pybind11;

// The atexit hook has begun: waiting makes no sense any more.
bool is_exiting() noexcept;

// How often this process has been forked on its way from the first one. Cheap.
std::uint64_t forks() noexcept;

// While it lives this thread works natively, without the GIL. At exit the GIL stays held: do not
// wait then.
class WithoutGil {
 public:
  WithoutGil();
  ~WithoutGil();
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  std::optional<py::gil_scoped_release> release_;
  std::uint64_t forks_ = 0;
};

// What native work returns that touches no Python, done while other Python threads may run. What it
// reads and writes belongs to an argument of the call, which Python keeps alive.
template <class Work>
auto without_gil(Work&& work) {
  const WithoutGil release;
  return work();
}

// For ever.
[[noreturn]] void sleep_until_the_end() noexcept;

// While it lives this thread has the GIL, as it may have had before. Does not return if the
// interpreter is gone.
class WithGil {
 public:
  WithGil();

 private:
  std::optional<py::gil_scoped_acquire> acquire_;
};

// Calls into Python from native work.
template <class Call>
decltype(auto) with_gil(Call&& call) {
  const WithGil gil;
#if defined(__GLIBCXX__) && !defined(__FreeBSD__)
  try {
    return call();
  } catch (abi::__forced_unwind&) {  // the interpreter has ended inside the call
    sleep_until_the_end();
  }
#else
  return call();
#endif
}

// Throws the Python exception of a signal that has arrived (Ctrl-C). With the GIL.
void check_signals();

// Before the interpreter ends: `stop` ends what waits; called without the GIL.
void on_exit(std::function<void()> stop);

// Registers the hooks; once, when the module is made.
void watch_exit_and_fork();

}  // namespace asap::python
