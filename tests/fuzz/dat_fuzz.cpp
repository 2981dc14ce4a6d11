// DatDecoder: any events, in both versions.
#include "asap/formats/prophesee.hpp"

#include "any_decoder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  asap::fuzz::Bytes bytes(data, size);
  const int version = bytes.flag() ? 1 : 2;
  asap::fuzz::check_decoder(asap::DatDecoder({.version = version}), bytes);
  return 0;
}
