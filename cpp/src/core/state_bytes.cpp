#include "core/state_bytes.hpp"

#include <algorithm>
#include <string>

#include "asap/core/check.hpp"
#include "asap/version.hpp"

namespace asap {
namespace {

constexpr std::string_view kMagic = "asap state ";
constexpr std::uint32_t kFormat = 1;  // in the machine's byte order: another order, another format
constexpr std::size_t kLeast = kMagic.size() + sizeof kFormat + sizeof(std::uint64_t);

// FNV-1a of 64 bits: whatever one byte is changed to, the sum differs.
std::uint64_t checksum(std::span<const std::byte> bytes) noexcept {
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (const std::byte byte : bytes) {
    sum = (sum ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3U;
  }
  return sum;
}

std::vector<char> letters(std::string_view text) { return {text.begin(), text.end()}; }

[[noreturn]] void refuse(std::string_view value, std::string_view remedy) {
  throw_bad_value("state", value, remedy);
}

}  // namespace

StateWriter::StateWriter(std::string_view name) {
  append(std::as_bytes(std::span(kMagic)));
  write(kFormat);
  write(letters(kVersion));
  write(letters(name));
}

void StateWriter::append(std::span<const std::byte> bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::vector<std::byte> StateWriter::finish() {
  write(checksum(bytes_));
  return std::exchange(bytes_, {});
}

StateReader::StateReader(std::string_view name, std::span<const std::byte> bytes)
    : name_(name), rest_(bytes) {
  const std::string size = std::to_string(bytes.size()) + " bytes";
  const auto magic = std::as_bytes(std::span(kMagic));
  if (bytes.size() < kLeast || !std::equal(magic.begin(), magic.end(), bytes.begin())) {
    refuse(size, "these are not what state() returned");
  }
  std::uint64_t sum = 0;
  const auto body = bytes.first(bytes.size() - sizeof sum);
  std::memcpy(&sum, bytes.last(sizeof sum).data(), sizeof sum);
  if (sum != checksum(body)) refuse(size, "they are truncated or altered");

  rest_ = body.subspan(kMagic.size());
  std::uint32_t format = 0;
  read(format);
  if (format != kFormat) refuse(size, "of another format, or another kind of machine");
  const auto text = [&] {
    std::vector<char> read_into;
    std::uint64_t length = 0;
    read(length);
    if (length > rest_.size()) refuse(size, "they are truncated or altered");
    read_into.resize(length);
    copy_to(read_into.data(), length);
    return std::string(read_into.begin(), read_into.end());
  };
  const std::string version = text();
  if (version != kVersion) {
    refuse("of asap " + version, "this is asap " + std::string(kVersion) +
                                     "; make it anew, or read it with the version that wrote it");
  }
  const std::string object = text();
  if (object != name) refuse("of " + object, "this is " + std::string(name));
}

void StateReader::finish() const {
  if (!rest_.empty()) refuse_configuration();
}

void StateReader::copy_to(void* out, std::size_t size) {
  if (size > rest_.size()) refuse_configuration();
  if (size > 0) std::memcpy(out, rest_.data(), size);
  rest_ = rest_.subspan(size);
}

void StateReader::refuse_configuration() const {
  refuse("of another " + std::string(name_),
         "make it with the parameters of the one that wrote it");
}

}  // namespace asap
