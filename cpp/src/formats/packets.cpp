#include "asap/formats/packets.hpp"

#include <algorithm>

#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

constexpr std::uint64_t kNsPerUs = 1000;
constexpr std::int64_t kLibcaerRange = std::int64_t{1} << 31;  // us

std::int64_t whole_us(std::uint64_t ns) { return static_cast<std::int64_t>(ns / kNsPerUs); }

}  // namespace

// ---- mono ---------------------------------------------------------------------------------------

void MonoDecoder::begin(std::uint64_t time_base_ns) noexcept {
  drop_unfinished();
  base_us_ = whole_us(time_base_ns);
  base_rest_ns_ = time_base_ns % kNsPerUs;
}

std::size_t MonoDecoder::decode_words(const std::byte* first, std::size_t count,
                                      Output& out) noexcept {
  const std::size_t records = std::min(count, out.room());
  const std::int64_t base_us = base_us_;
  const std::uint64_t rest_ns = base_rest_ns_;
  Event* const events = out.event;
  for (std::size_t i = 0; i < records; ++i) {
    const auto word = load_little<std::uint64_t>(first + i * sizeof(std::uint64_t));
    write_event(&events[i], word >> 32 & 0xffff, word >> 48 & 0x7fff, word >> 63,
                base_us + whole_us(rest_ns + (word & 0xffffffff)));
  }
  out.event += records;
  return records;
}

template class NativeDecoder<MonoDecoder, PacketConfig, 8>;

// ---- libcaer ------------------------------------------------------------------------------------

void LibcaerDecoder::begin(std::uint64_t time_base_ns) noexcept {
  drop_unfinished();
  base_us_ = whole_us(time_base_ns);
  last_stamp_ = 0;
}

std::size_t LibcaerDecoder::decode_words(const std::byte* first, std::size_t count,
                                         Output& out) noexcept {
  std::size_t i = 0;
  std::int64_t base_us = base_us_;
  std::int32_t last = last_stamp_;
  Event* event = out.event;
  for (; i < count && event != out.events_end; ++i) {
    const std::byte* at = first + i * sizeof(std::uint64_t);
    const auto data = load_little<std::uint32_t>(at);
    const auto stamp =
        static_cast<std::int32_t>(load_little<std::uint32_t>(at + sizeof(std::uint32_t)));
    if (stamp < last) [[unlikely]] {
      if (stamp < 0) {
        bad_.add(offset_ + i * sizeof(std::uint64_t));
        continue;
      }
      if (last - stamp > kLibcaerRange / 2) base_us += kLibcaerRange;
    }
    last = stamp;
    write_event(event++, data >> 17, data >> 2 & 0x7fff, data >> 1 & 1, base_us + stamp);
  }
  out.event = event;
  base_us_ = base_us;
  last_stamp_ = last;
  return i;
}

template class NativeDecoder<LibcaerDecoder, PacketConfig, 8>;

// ---- libcaer_cmp --------------------------------------------------------------------------------

void LibcaerCmpDecoder::begin(std::uint64_t time_base_ns) noexcept {
  drop_unfinished();
  base_us_ = whole_us(time_base_ns);
  registers_.high = registers_.low = 0;
}

std::size_t LibcaerCmpDecoder::decode_words(const std::byte* first, std::size_t count,
                                            Output& out) noexcept {
  enum Code : std::uint32_t { time_high, time_low, addr_x, addr_y, vect_base_y, vect_8 };
  Registers now = registers_;
  const std::int64_t base_us = base_us_;
  std::size_t i = 0;
  while (i < count && out.room() >= kMaxPerRecord) {
    // A plain word gives at most one event, so that only a vector has to look at the room again.
    // It always writes; what is no event is overwritten by the next.
    const std::size_t stop = i + std::min(count - i, out.room() - (kMaxPerRecord - 1));
    std::uint32_t word = 0, code = 0;
    Event* event = out.event;
    for (; i < stop; ++i) {
      word = load_little<std::uint16_t>(first + i * sizeof(std::uint16_t));
      code = word >> 12;
      if (code > addr_y) break;
      const std::int64_t time = word & 0xfff;
      now.high = code == time_high ? time << 12 : now.high;
      now.low = code == time_low ? time : now.low;
      now.x = code == addr_x ? word & 0x7ff : now.x;
      write_event(event, now.x, word & 0x7ff, word >> 11 & 1, base_us + (now.high | now.low));
      event += code == addr_y;
    }
    out.event = event;
    if (i == stop) continue;
    if (code == vect_base_y) {
      now.base_y = word & 0x7ff;
      now.base_p = word >> 11 & 1;
    } else if (code == vect_8) {
      const std::int64_t t = base_us + (now.high | now.low);
      for (std::uint32_t bit = 0; bit < 8; ++bit) {
        write_event(out.event, now.x, (now.base_y + bit) & 0xffff, now.base_p, t);
        out.event += word >> bit & 1;
      }
      now.base_y = (now.base_y + 8) & 0xffff;
    } else {
      bad_.add(offset_ + i * sizeof(std::uint16_t));
    }
    ++i;
  }
  registers_ = now;
  return i;
}

template class NativeDecoder<LibcaerCmpDecoder, PacketConfig, 2>;

// ---- dvs_msgs -----------------------------------------------------------------------------------

namespace {

constexpr std::size_t kDvsSize = 13;  // size of a record in ROS 1 and of the first one in CDR
constexpr std::size_t kCdrStride =
    16;  // step of the timestamps in CDR; x and y move 2 bytes to the front

std::int64_t dvs_time(const std::byte* at) {
  const std::int64_t s = load_little<std::uint32_t>(at);
  return s * 1'000'000 + whole_us(load_little<std::uint32_t>(at + 4));
}

void write_dvs(Event* out, const std::byte* place, const std::byte* stamp) {
  write_event(out, load_little<std::uint16_t>(place), load_little<std::uint16_t>(place + 2),
              stamp[8] != std::byte{0}, dvs_time(stamp));
}

}  // namespace

std::size_t DvsRecords::whole() const noexcept {
  if (layout_ == Layout::ros1) return bytes_.size() / kDvsSize;
  return (bytes_.size() + (kCdrStride - kDvsSize)) / kCdrStride;
}

void DvsRecords::decode(std::size_t first, std::span<Event> events) const noexcept {
  std::size_t i = 0;
  if (layout_ == Layout::cdr && first == 0 && !events.empty()) {
    write_dvs(&events[i++], bytes_.data(), bytes_.data() + 4);  // no padding before its timestamp
  }
  const std::size_t stride = layout_ == Layout::ros1 ? kDvsSize : kCdrStride;
  const std::size_t forward = layout_ == Layout::ros1 ? 0 : 2;
  for (; i < events.size(); ++i) {
    const std::byte* record = bytes_.data() + (first + i) * stride;
    write_dvs(&events[i], record - forward, record + 4);
  }
}

}  // namespace asap::inline v0_1
