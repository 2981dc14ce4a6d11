// read_raw_header, read_dat_header: any bytes. A header lies within them and ends a line.
#include "asap/formats/prophesee.hpp"

#include "bytes.hpp"

using namespace asap;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::uint8_t> exact(data, data + size);
  const auto bytes = std::as_bytes(std::span(exact));
  const auto header = read_raw_header(bytes);
  if (header) {
    fuzz::check(header->size > 0 && header->size <= size && data[header->size - 1] == '\n');
    fuzz::check((header->width == 0) == (header->height == 0));
  }
  if (const auto dat = read_dat_header(bytes)) {
    fuzz::check(header && dat->size == header->size + 2 && dat->size <= size);
    fuzz::check(header->words == RawHeader::Words::unknown);
  }
  return 0;
}
