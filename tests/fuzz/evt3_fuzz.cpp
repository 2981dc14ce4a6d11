// Evt3Decoder: any words.
#include "asap/formats/prophesee.hpp"

#include "any_decoder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  asap::fuzz::Bytes bytes(data, size);
  asap::fuzz::check_decoder(asap::Evt3Decoder{}, bytes);
  return 0;
}
