// A scheme whose rule is a lambda, and which writes down what it is told: exempt from what a scheme
// promises.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "asap/core/nonblocking.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap::test {

class ScriptedScheme final : public Scheme {
 public:
  using Rule = std::function<Decision(const Backlog&)>;

  explicit ScriptedScheme(Rule rule) : rule_(std::move(rule)) {}

  Decision decide(const Backlog& backlog) noexcept override {
    return exempt([&] { return rule_(backlog); });
  }
  void observe(const Outcome& outcome) noexcept override {
    exempt([&] { outcomes.push_back(outcome); });
  }
  void reset(Execution e) noexcept override {
    ++resets;
    execution = e;
  }
  std::string_view name() const noexcept override { return "scripted"; }

  std::vector<Outcome> outcomes;
  int resets = 0;
  Execution execution = Execution::whole;

 private:
  Rule rule_;
};

}  // namespace asap::test
