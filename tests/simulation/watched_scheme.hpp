// WatchedScheme: stands between the packager and a scheme and tells a watcher of every word. While
// a scheme thinks, the producer goes on: the watcher may push in between.
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap::simulation {

class SchemeWatcher {
 public:
  virtual void asked(const Backlog& backlog) noexcept = 0;
  virtual void decided(const Backlog& backlog, const Decision& decision) noexcept = 0;
  virtual void told(const Outcome& outcome) noexcept = 0;

 protected:
  ~SchemeWatcher() = default;
};

class WatchedScheme final : public Scheme {
 public:
  WatchedScheme(Scheme& scheme, SchemeWatcher& watcher) noexcept
      : scheme_(scheme), watcher_(watcher) {}

  Decision decide(const Backlog& backlog) noexcept override {
    watcher_.asked(backlog);
    const Decision decision = scheme_.decide(backlog);
    watcher_.decided(backlog, decision);
    return decision;
  }
  void observe(const Outcome& outcome) noexcept override {
    watcher_.told(outcome);
    scheme_.observe(outcome);
  }
  void reset(Execution execution) noexcept override { scheme_.reset(execution); }
  std::string_view name() const noexcept override { return scheme_.name(); }
  std::int64_t latency_bound_ns() const noexcept override { return scheme_.latency_bound_ns(); }
  void set_latency_bound_ns(std::int64_t bound_ns) noexcept override {
    scheme_.set_latency_bound_ns(bound_ns);
  }

 private:
  Scheme& scheme_;
  SchemeWatcher& watcher_;
};

}  // namespace asap::simulation
