// Evt21Decoder: any words, in both orders.
#include "asap/formats/prophesee.hpp"

#include "any_decoder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  asap::fuzz::Bytes bytes(data, size);
  const bool little_endian = bytes.flag();
  asap::fuzz::check_decoder(asap::Evt21Decoder({.little_endian = little_endian}), bytes);
  return 0;
}
