// Aedat3Decoder and its header: any bytes, of one camera or all. Between bytes that are none it
// finds a packet that is one.
#include "any_decoder.hpp"
#include "asap/formats/aedat.hpp"

using namespace asap;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto front = std::as_bytes(std::span(data, size));
  if (const auto header = read_aedat3_header(front)) fuzz::check(header->size <= size);
  fuzz::Bytes bytes(data, size);
  fuzz::check_decoder(Aedat3Decoder({.source = bytes.flag() ? 0 : -1}), bytes);
  return 0;
}
