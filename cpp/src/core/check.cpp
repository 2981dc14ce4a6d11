#include "asap/core/check.hpp"

#include <cstdio>
#include <stdexcept>

namespace asap {

void throw_bad_value(std::string_view field, std::string_view value, std::string_view remedy) {
  std::string message;
  message.append(field).append(" = ").append(value).append(": ").append(remedy);
  throw std::invalid_argument(message);
}

std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

static std::string in_unit(std::chrono::nanoseconds time, TimeUnit unit) {
  return to_text(static_cast<double>(time.count()) / (unit == TimeUnit::ms ? 1e6 : 1e3));
}

BadTime::BadTime(std::string_view field_name, std::chrono::nanoseconds time, TimeUnit time_unit,
                 std::string_view advice)
    : invalid_argument([&] {
        const bool is_ms = time_unit == TimeUnit::ms;
        std::string message(field_name);
        message.append(" = ").append(in_unit(time, time_unit)).append(is_ms ? " ms: " : " us: ");
        return message.append(advice);
      }()),
      field(field_name),
      value(in_unit(time, time_unit)),
      unit(time_unit == TimeUnit::ms ? "ms" : "us"),
      remedy(advice) {}

void require_time(bool ok, std::string_view field, std::chrono::nanoseconds value, TimeUnit unit,
                  std::string_view remedy) {
  if (!ok) throw BadTime(field, value, unit, remedy);
}

std::int64_t checked_latency_ns(std::chrono::nanoseconds latency) {
  using namespace std::chrono_literals;
  require_time(latency >= 10us && latency <= 10'000s, "latency", latency, TimeUnit::ms,
               "must be between 0.01 and 1e7 ms");
  return latency.count();
}

void detail::throw_no_memory(std::string_view field, std::size_t value, double bytes) {
  constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;
  char size[32];
  std::snprintf(size, sizeof size, "%.3g GiB", bytes / kGibibyte);
  std::string message;
  message.append(field).append(" = ").append(std::to_string(value));
  message.append(": needs ").append(size);
  message.append(" of memory, which cannot be had; choose less");
  throw NoMemory(message);
}

}  // namespace asap
