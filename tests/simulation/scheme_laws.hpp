// Scheme laws: what the schemes' headers promise of every single decision: sizes, fractions,
// budgets, and that nothing is waited for when it is due.
#pragma once

#include "asap/schemes/scheme.hpp"
#include "journal.hpp"
#include "setup.hpp"

namespace asap::simulation {

void hold_decision(const Setup& setup, const Backlog& backlog, const Decision& decision,
                   Journal& journal);

}  // namespace asap::simulation
