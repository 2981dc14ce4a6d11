// EventStreamDecoder and its header: any bytes, in both versions.
#include "any_decoder.hpp"
#include "asap/formats/atis.hpp"

using namespace asap;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto front = std::as_bytes(std::span(data, size));
  if (const auto header = read_event_stream_header(front)) fuzz::check(header->size <= size);
  fuzz::Bytes bytes(data, size);
  fuzz::check_decoder(EventStreamDecoder({.version = bytes.flag() ? 1 : 2, .height = 240}), bytes);
  return 0;
}
