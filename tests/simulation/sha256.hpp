// Sha256: the fingerprint of a run (FIPS 180-4). Numbers are fed as little-endian 64-bit words,
// never as memory: no padding, the same on every machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace asap::simulation {

class Sha256 {
 public:
  void feed(std::uint8_t byte) noexcept;
  void feed(std::uint64_t number) noexcept {
    for (int shift = 0; shift < 64; shift += 8) feed(static_cast<std::uint8_t>(number >> shift));
  }
  // In hexadecimal digits. Nothing may be fed afterwards.
  std::string finish();

 private:
  void mix_block() noexcept;

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> block_{};
  std::uint64_t bytes_ = 0;
};

}  // namespace asap::simulation
