// Atis40Decoder: any bytes, with marks and without.
#include "any_decoder.hpp"
#include "asap/formats/atis.hpp"

using namespace asap;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  fuzz::check_decoder(Atis40Decoder({.marks = bytes.flag()}), bytes);
  return 0;
}
