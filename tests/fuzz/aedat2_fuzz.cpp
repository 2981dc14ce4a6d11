// Aedat2Decoder and its header: any bytes, under any configuration.
#include "asap/formats/aedat.hpp"

#include <stdexcept>

#include "any_decoder.hpp"

using namespace asap;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto front = std::as_bytes(std::span(data, size));
  if (const auto header = read_aedat2_header(front)) fuzz::check(header->size <= size);
  fuzz::Bytes bytes(data, size);
  const Aedat2Config config{.chip = static_cast<Aedat2Chip>(bytes.below(6)),
                            .width = static_cast<std::uint16_t>(bytes.count(2048)),
                            .height = static_cast<std::uint16_t>(bytes.count(1024))};
  try {
    fuzz::check_decoder(Aedat2Decoder(config), bytes);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
