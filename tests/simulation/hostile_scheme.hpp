// HostileScheme: a user's scheme that answers nonsense: NaN, infinities, negative budgets, more
// than there is, waits that are over. Whatever it says, the packager keeps its promises.
#pragma once

#include "asap/schemes/scheme.hpp"
#include "draw.hpp"

namespace asap::simulation {

class HostileScheme final : public Scheme {
 public:
  explicit HostileScheme(std::uint64_t key) noexcept : draw_(key, 2) {}

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "hostile"; }

 private:
  Draw draw_;
};

}  // namespace asap::simulation
