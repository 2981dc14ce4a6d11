// The state of an object as flat bytes, and back. A class lists what its work changes, and any
// class in that list does the same:
//   static auto saved(auto& self) noexcept { return std::tie(self.cursor_, self.entries_); }
// Plain values are copied as they lie in memory, vectors behind their size. What follows from the
// configuration is made anew by the constructor; same(...) in the list says what must agree. The
// bytes begin with a format, the library's version and the object's name and end with a checksum,
// which is for accidents: bytes made to deceive may do anything. Any thread. O(bytes); StateReader
// does not allocate.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace asap {

// Values of the configuration, which must be those of the object that wrote the bytes.
template <class... Values>
struct Same {
  std::tuple<Values...> values;
};

template <class... Values>
auto same(const Values&... values) {
  return std::tuple(Same<Values...>{{values...}});
}

class StateWriter {
 public:
  explicit StateWriter(std::string_view name);

  template <class Value>
  void write(const Value& value) {
    if constexpr (requires { Value::saved(value); }) {
      write_each(Value::saved(value));
    } else {
      static_assert(std::is_trivially_copyable_v<Value>, "give it a list saved()");
      append({reinterpret_cast<const std::byte*>(&value), sizeof value});
    }
  }

  template <class Value>
  void write(const std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    write(std::uint64_t{values.size()});
    append(std::as_bytes(std::span(values)));
  }

  template <class... Values>
  void write(const Same<Values...>& same) {
    write_each(same.values);
  }

  // With the checksum. The writer is empty then.
  std::vector<std::byte> finish();

 private:
  template <class Tuple>
  void write_each(const Tuple& values) {
    std::apply([&](const auto&... value) { (write(value), ...); }, values);
  }

  void append(std::span<const std::byte> bytes);

  std::vector<std::byte> bytes_;
};

class StateReader {
 public:
  // Throws std::invalid_argument unless the bytes are whole, of this version and of that name.
  StateReader(std::string_view name, std::span<const std::byte> bytes);

  template <class Value>
  void read(Value& value) {
    if constexpr (requires { Value::saved(value); }) {
      read_each(Value::saved(value));
    } else {
      static_assert(std::is_trivially_copyable_v<Value>, "give it a list saved()");
      copy_to(&value, sizeof value);
    }
  }

  // Into the memory that the vector has.
  template <class Value>
  void read(std::vector<Value>& values) {
    std::uint64_t size = 0;
    read(size);
    if (size > values.capacity()) refuse_configuration();
    values.resize(size);
    copy_to(values.data(), size * sizeof(Value));
  }

  template <class... Values>
  void read(Same<Values...>& same) {
    std::apply([&](const auto&... value) { (expect(value), ...); }, same.values);
  }

  // Throws if something is left.
  void finish() const;

 private:
  template <class Tuple>
  void read_each(Tuple&& values) {
    std::apply([&](auto&... value) { (read(value), ...); }, values);
  }

  template <class Value>
  void expect(const Value& own) {
    Value theirs{};
    read(theirs);
    if (theirs != own) refuse_configuration();
  }

  template <class Value>
  void expect(const std::vector<Value>& own) {
    expect(std::uint64_t{own.size()});
    for (const Value& value : own) expect(value);
  }

  void copy_to(void* out, std::size_t size);
  [[noreturn]] void refuse_configuration() const;

  std::string_view name_;
  std::span<const std::byte> rest_;
};

// All of an object, and back; what a public state() and restore() consist of.
template <class... Parts>
std::vector<std::byte> state_bytes(std::string_view name, const Parts&... parts) {
  StateWriter writer(name);
  (writer.write(parts), ...);
  return writer.finish();
}

template <class... Parts>
void restore_state(std::string_view name, std::span<const std::byte> bytes, Parts&... parts) {
  StateReader reader(name, bytes);
  (reader.read(parts), ...);
  reader.finish();
}

}  // namespace asap
