// What the compiler has to refuse under -Wfunction-effects: a scheme, which has the mark from its
// base, locks; a marked function allocates.
#include <mutex>

#include "asap/core/nonblocking.hpp"
#include "asap/schemes/scheme.hpp"

namespace {

class Locking final : public asap::Scheme {
 public:
  asap::Decision decide(const asap::Backlog& backlog) noexcept override {
    mutex_.lock();
    return asap::Decision::take(backlog.count);
  }
  std::string_view name() const noexcept override { return "locking"; }

 private:
  std::mutex mutex_;
};

int* allocating() noexcept ASAP_NONBLOCKING { return new int(1); }

}  // namespace

int main() {
  Locking scheme;
  delete allocating();
  return scheme.name().empty() ? 1 : 0;
}
