// StdAtomics: the atomics of the production build, as the policy of every class that two threads
// share. A model checker passes its own and so runs the same source: tests/model/relacy.
#pragma once

#include <atomic>

namespace asap {

struct StdAtomics {
  template <class Value>
  using Atomic = std::atomic<Value>;
};

}  // namespace asap
