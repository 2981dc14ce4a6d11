// Journal: numbers the steps of a run, keeps the last of them, and notes the first check that did
// not hold. A run is over when one has failed, or when it has come to the step asked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

namespace asap::simulation {

// What must hold at every step (reliability, section 7), and that the parts keep to what their
// headers say.
enum class Law {
  ledger,
  order,
  size,
  gamma,
  identity,
  pending,
  age,
  kept_set,
  liveness,
  protocol,
};

const char* name(Law law) noexcept;

class Journal {
 public:
  explicit Journal(std::uint64_t until) noexcept : until_(until) {}

  void step(const char* what, std::int64_t time_ns, std::uint64_t a = 0,
            std::uint64_t b = 0) noexcept {
    if (over()) return;
    lines_[steps_ % lines_.size()] = {what, time_ns, a, b};
    ++steps_;
  }
  bool over() const noexcept { return failed_ || steps_ >= until_; }
  std::uint64_t steps() const noexcept { return steps_; }

  void hold(Law law, bool ok, const char* what, double got = 0, double wanted = 0) noexcept {
    if (!ok) fail(law, what, got, wanted);
  }
  template <class A, class B>
  void equal(Law law, const A& got, const B& wanted, const char* what) noexcept {
    if (!(got == wanted)) {
      fail(law, what, static_cast<double>(got), static_cast<double>(wanted));
    }
  }

  bool failed() const noexcept { return failed_; }
  Law law() const noexcept { return law_; }
  std::string violation() const;   // one line
  std::string last_steps() const;  // one line each

 private:
  struct Line {
    const char* what;
    std::int64_t time_ns;
    std::uint64_t a;
    std::uint64_t b;
  };

  void fail(Law law, const char* what, double got, double wanted) noexcept;

  const std::uint64_t until_;
  std::uint64_t steps_ = 0;
  std::array<Line, 32> lines_{};
  bool failed_ = false;
  Law law_ = Law::protocol;
  const char* what_ = "";
  double got_ = 0;
  double wanted_ = 0;
};

}  // namespace asap::simulation
