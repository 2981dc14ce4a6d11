// Consumer: the algorithm as a runner sees it, a callable that takes a package (or, by conversion,
// its events). Called on the consumer's thread, once per package; where the execution is anytime,
// once per part of it (package.continues from the second on).
#pragma once

#include <functional>

#include "asap/packager/package.hpp"

namespace asap {

using Consumer = std::function<void(const Package&)>;

}  // namespace asap
