// soak PART SECONDS [SEED]: one part in a process of its own, so that its memory is its own.
#include <cstdlib>
#include <functional>
#include <map>
#include <string>

#include "parts.hpp"

int main(int argc, char** argv) {
  using namespace asap::soak;
  const std::map<std::string, std::function<void(double, std::uint64_t)>> parts{
      {"ledger", ledger},
      {"steady", steady},
      {"overload", overload},
      {"saturation", saturation},
      {"idle", idle}};
  const auto part = parts.find(argc > 1 ? argv[1] : "");
  if (part == parts.end() || argc < 3) {
    std::cerr << "usage: soak PART SECONDS [SEED], PART one of:";
    for (const auto& [name, run] : parts) std::cerr << ' ' << name;
    std::cerr << '\n';
    return 2;
  }
  std::cout.precision(12);
  part->second(std::strtod(argv[2], nullptr), argc > 3 ? std::strtoull(argv[3], nullptr, 0) : 1);
}
