#include "core/check.hpp"

#include <cstdio>

namespace asap::inline v0_1 {

BadValue::BadValue(std::string_view its_field, std::string_view its_value,
                   std::string_view its_unit, std::string_view its_remedy)
    : invalid_argument([&] {
        std::string message(its_field);
        message.append(" = ").append(its_value);
        if (!its_unit.empty()) message.append(" ").append(its_unit);
        return message.append(": ").append(its_remedy);
      }()),
      field(its_field),
      value(its_value),
      unit(its_unit),
      remedy(its_remedy) {}

void throw_bad_value(std::string_view field, std::string_view value, std::string_view remedy) {
  throw BadValue(field, value, {}, remedy);
}

std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

void require_time(bool ok, std::string_view field, std::chrono::nanoseconds value, TimeUnit unit,
                  std::string_view remedy) {
  if (ok) return;
  const bool is_ms = unit == TimeUnit::ms;
  throw BadValue(field, to_text(static_cast<double>(value.count()) / (is_ms ? 1e6 : 1e3)),
                 is_ms ? "ms" : "us", remedy);
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

}  // namespace asap::inline v0_1
