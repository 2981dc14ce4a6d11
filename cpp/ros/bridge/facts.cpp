#include "ros/bridge/facts.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace asap::ros {
namespace {

constexpr std::pair<const char*, std::uint64_t Ledger::*> kLines[] = {
    {"delivered", &Ledger::delivered}, {"rejected", &Ledger::rejected},
    {"filtered", &Ledger::filtered},   {"discarded", &Ledger::discarded},
    {"stale", &Ledger::stale},         {"overflow", &Ledger::overflow},
    {"pending", &Ledger::pending}};

double per(double amount, double of) { return of > 0 ? amount / of : 0.0; }

std::string share(std::uint64_t part, std::uint64_t whole) {
  return number(static_cast<double>(part) / static_cast<double>(whole));  // of nothing: null
}

std::string quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20) {
      std::array<char, 8> code{};
      std::snprintf(code.data(), code.size(), "\\u%04x", static_cast<unsigned>(c));
      quoted += code.data();
    } else {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

std::string to_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.12g", value);
  return text.data();
}

std::string number(double value) { return std::isfinite(value) ? to_text(value) : "null"; }

std::string number(std::uint64_t value) { return std::to_string(value); }

Fact text(std::string name, std::string_view value) {
  return {std::move(name), std::string(value), true};
}

Facts facts_of(const PipelineStats& stats) {
  const Ledger& ledger = stats.ledger;
  const Rejections& rejected = stats.rejected;
  const LatencyHistogram& latency = stats.latency;
  const std::uint64_t count = stats.packages.count, size = stats.packages.size;
  const double elapsed_s = static_cast<double>(stats.elapsed_ns) * 1e-9;
  const double busy_s = static_cast<double>(stats.packages.processing_ns) * 1e-9;
  const auto us = [](auto ns) { return number(static_cast<double>(ns) * 1e-3); };
  Facts facts{{"latency_bound_us", us(stats.latency_bound_ns)},
              {"ledger.received", number(ledger.received)}};
  for (const auto& [name, line] : kLines) {
    facts.push_back({std::string("ledger.") + name, number(ledger.*line)});
  }
  const Facts rest{
      {"rejected.nonmonotonic", number(rejected.nonmonotonic)},
      {"rejected.out_of_bounds", number(rejected.out_of_bounds)},
      {"rejected.bad_polarity", number(rejected.bad_polarity)},
      {"rejected.bad_record", number(rejected.bad_record)},
      {"rejected.before_start", number(rejected.before_start)},
      {"clock_resets", number(stats.clock_resets)},
      {"upstream_lost.marks", number(stats.upstream_marks)},
      {"upstream_lost.packets", number(stats.upstream_packets)},
      {"sensor_delay_us.last", us(stats.sensor_delay_ns)},
      {"sensor_delay_us.max", us(stats.sensor_delay_max_ns)},
      {"max_waiting", number(stats.max_waiting)},
      {"kept", share(ledger.delivered, ledger.received)},
      {"in_time", share(latency.within_bound(), ledger.received)},
      {"latency_us.mean", us(latency.mean_ns())},
      {"latency_us.p50", us(latency.quantile_ns(0.5))},
      {"latency_us.p99", us(latency.quantile_ns(0.99))},
      {"latency_us.max", us(latency.max_ns())},
      {"gap_us", number(static_cast<std::uint64_t>(stats.gap_us))},
      {"packages.count", number(count)},
      {"packages.per_s", number(per(static_cast<double>(count), elapsed_s))},
      {"packages.size_mean", number(per(static_cast<double>(size), static_cast<double>(count)))},
      {"packages.size_max", number(stats.packages.size_max)},
      {"gamma.mean", stats.packages.to_gamma == 0 ? "1" : share(size, stats.packages.to_gamma)},
      {"gamma.min", number(stats.packages.gamma_min)},
      {"cpu", number(per(busy_s, elapsed_s))}};
  facts.insert(facts.end(), rest.begin(), rest.end());
  return facts;
}

std::string to_json(const Facts& facts) {
  std::string json = "{", object;
  const auto close = [&] { json += object.empty() ? "" : "}"; };
  for (const auto& [name, value, is_text] : facts) {
    const std::size_t dot = name.find('.');
    const std::string of = dot == std::string::npos ? "" : name.substr(0, dot);
    const bool begins = of.empty() || of != object;
    if (begins) close();
    if (json.size() > 1) json += ", ";
    if (begins && !of.empty()) json += quoted(of) + ": {";
    json +=
        quoted(name.substr(dot + 1)) + ": " + (is_text ? quoted(value) : value);  // npos + 1 is 0
    object = of;
  }
  close();
  return json + "}";
}

std::string sentence(const Ledger& ledger) {
  std::string sum;
  for (const auto& [name, line] : kLines) {
    if (ledger.*line == 0) continue;
    sum += (sum.empty() ? "" : " + ") + std::string(name) + " " + std::to_string(ledger.*line);
  }
  return "received " + std::to_string(ledger.received) + " = " + (sum.empty() ? "0" : sum) +
         (ledger.balanced() ? "" : " (does not add up)");
}

}  // namespace asap::ros
