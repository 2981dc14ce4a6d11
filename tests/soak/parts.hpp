// The parts of the soak. Each runs for about so many seconds and prints its figures, one a line:
// name and value. What they shall be says soak.py.
#pragma once

#include <cstdint>
#include <iostream>
#include <string_view>

namespace asap::soak {

void ledger(double seconds, std::uint64_t seed);      // R1, R7, R13, R14
void steady(double seconds, std::uint64_t seed);      // R3, R6
void overload(double seconds, std::uint64_t seed);    // R4, R6
void saturation(double seconds, std::uint64_t seed);  // R5
void idle(double seconds, std::uint64_t seed);        // R19

template <class Value>
void figure(std::string_view name, Value value) {
  std::cout << name << ' ' << value << '\n';
}

}  // namespace asap::soak
