// Decimal: any text is read within its bounds, and rounding agrees with long double arithmetic.
#include <cmath>
#include <cstdlib>
#include <string>

#include "bytes.hpp"
#include "formats/decimal.hpp"

using namespace asap;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const int shift = static_cast<int>(bytes.take<std::uint8_t>() % 19) - 9;
  const auto rest = bytes.rest();
  const std::string text(rest.begin(), rest.end());
  Decimal number;
  const char* const end = read_decimal(text.data(), text.data() + text.size(), number);
  if (end == nullptr) return 0;
  const auto length = static_cast<std::size_t>(end - text.data());
  fuzz::check(length >= 1 && length <= text.size());

  const Rounded rounded = round_decimal(number, shift);
  fuzz::check(rounded.value >= -Rounded::kHuge && rounded.value <= Rounded::kHuge);
  fuzz::check(rounded.value == 0 || (rounded.value < 0) == number.negative);

  // What strtold makes of the same characters; its mantissa has 64 bits.
  const std::string word = text.substr(0, length);
  const long double value = std::strtold(word.c_str(), nullptr) * std::pow(10.0L, shift);
  if (std::isfinite(value) && std::abs(value) < 0x1p60L) {
    fuzz::check(std::abs(static_cast<long double>(rounded.value) - value) <=
                0.5L + std::abs(value) * 0x1p-62L);
  } else if (std::abs(value) > 0x1p62L) {
    fuzz::check(rounded.value == (number.negative ? -Rounded::kHuge : Rounded::kHuge));
  }
  return 0;
}
