// MonoDecoder, LibcaerDecoder, LibcaerCmpDecoder, DvsRecords: any bytes as a few messages. How they
// are cut and how much room there is makes no difference; every record is events or counted.
#include "asap/formats/packets.hpp"

#include <algorithm>
#include <vector>

#include "any_decoder.hpp"

using namespace asap;

namespace {

template <class Decoder>
void check_messages(fuzz::Bytes& bytes) {
  const std::size_t piece = 1 + bytes.below(64);
  fuzz::Room& ample = fuzz::ample_room();
  fuzz::Room little(Decoder::kMaxPerRecord + bytes.below(16), 1);
  Decoder whole, cut;
  while (!bytes.empty()) {
    const auto base = bytes.take<std::uint64_t>();
    const std::size_t size = bytes.below(512);
    const auto rest = std::as_bytes(bytes.rest());
    const auto message = rest.first(std::min(rest.size(), size));
    for (std::size_t i = 0; i < message.size(); ++i) bytes.take<std::uint8_t>();
    whole.begin(base);
    cut.begin(base);
    const auto decoded = fuzz::decode_in_pieces(whole, message, message.size(), ample);
    fuzz::check(fuzz::decode_in_pieces(cut, message, piece, little) == decoded);
    fuzz::check(fuzz::same_books(whole, cut));
  }
}

void check_records(fuzz::Bytes& bytes) {
  const auto layout = bytes.flag() ? DvsRecords::Layout::ros1 : DvsRecords::Layout::cdr;
  const std::size_t piece = 1 + bytes.below(64);
  const auto rest = bytes.rest();
  const std::vector<std::uint8_t> copy(rest.begin(), rest.end());  // its end is watched
  const DvsRecords records(std::as_bytes(std::span(copy)), layout);
  std::vector<Event> events(records.whole()), same;
  records.decode(0, events);
  for (std::size_t at = 0; at < events.size(); at += piece) {
    std::vector<Event> some(std::min(piece, events.size() - at));
    records.decode(at, some);
    same.insert(same.end(), some.begin(), some.end());
  }
  fuzz::check(events == same);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  switch (bytes.below(4)) {
    case 0:
      check_messages<MonoDecoder>(bytes);
      break;
    case 1:
      check_messages<LibcaerDecoder>(bytes);
      break;
    case 2:
      check_messages<LibcaerCmpDecoder>(bytes);
      break;
    default:
      check_records(bytes);
  }
  return 0;
}
