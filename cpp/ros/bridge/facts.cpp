#include "ros/bridge/facts.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>

#include "asap/core/check.hpp"

namespace asap::ros {
namespace {

constexpr std::pair<const char*, std::uint64_t Ledger::*> kLines[] = {
    {"delivered", &Ledger::delivered}, {"rejected", &Ledger::rejected},
    {"filtered", &Ledger::filtered},   {"discarded", &Ledger::discarded},
    {"stale", &Ledger::stale},         {"overflow", &Ledger::overflow},
    {"pending", &Ledger::pending}};

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

double per(double amount, double of) { return of > 0 ? amount / of : 0.0; }

}  // namespace

std::string number(double value) { return std::isfinite(value) ? to_text(value) : "null"; }

std::string number(std::uint64_t value) { return std::to_string(value); }

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

Facts facts_of(const PipelineStats& stats) {
  const Ledger& ledger = stats.ledger;
  const PackageTotals& packages = stats.packages;
  const double elapsed_s = static_cast<double>(stats.elapsed_ns) * 1e-9;
  const auto us = [](auto ns) { return number(static_cast<double>(ns) * 1e-3); };
  const auto ratio = [](std::uint64_t a, std::uint64_t b) {
    return number(per(static_cast<double>(a), static_cast<double>(b)));
  };
  Facts facts{{"latency_bound_us", us(stats.latency_bound_ns)},
              {"ledger.received", number(ledger.received)}};
  for (const auto& [name, line] : kLines) {
    facts.emplace_back(std::string("ledger.") + name, number(ledger.*line));
  }
  for (const auto& [name, count] : std::initializer_list<std::pair<const char*, std::uint64_t>>{
           {"nonmonotonic", stats.rejected.nonmonotonic},
           {"out_of_bounds", stats.rejected.out_of_bounds},
           {"bad_polarity", stats.rejected.bad_polarity},
           {"bad_record", stats.rejected.bad_record},
           {"before_start", stats.rejected.before_start}}) {
    facts.emplace_back(std::string("rejected.") + name, number(count));
  }
  const Facts rest{
      {"clock_resets", number(stats.clock_resets)},
      {"upstream_lost.marks", number(stats.upstream_marks)},
      {"upstream_lost.packets", number(stats.upstream_packets)},
      {"sensor_delay_us.last", us(stats.sensor_delay_ns)},
      {"sensor_delay_us.max", us(stats.sensor_delay_max_ns)},
      {"most_waiting", number(stats.most_waiting)},
      {"kept", number(share(ledger.delivered, ledger.received))},
      {"in_time", number(share(stats.latency.within_bound(), ledger.received))},
      {"latency_us.mean", us(stats.latency.mean_ns())},
      {"latency_us.p50", us(stats.latency.quantile_ns(0.5))},
      {"latency_us.p99", us(stats.latency.quantile_ns(0.99))},
      {"latency_us.max", us(stats.latency.max_ns())},
      {"packages.count", number(packages.count.load())},
      {"packages.per_s", number(per(static_cast<double>(packages.count.load()), elapsed_s))},
      {"packages.size_mean", ratio(packages.size, packages.count)},
      {"packages.size_max", number(packages.size_max.load())},
      {"gamma.mean", number(share(packages.size, packages.thinned))},
      {"gamma.min", number(packages.gamma_min.load())},
      {"cpu", number(per(static_cast<double>(packages.processing_ns.load()) * 1e-9, elapsed_s))}};
  facts.insert(facts.end(), rest.begin(), rest.end());
  return facts;
}

std::string to_json(const Facts& facts) {
  std::string json = "{", object;
  const auto close = [&] {
    if (!object.empty()) json += '}';
    object.clear();
  };
  for (const auto& [name, value] : facts) {
    const std::size_t dot = name.find('.');
    const std::string of = dot == std::string::npos ? "" : name.substr(0, dot);
    const bool goes_on = !of.empty() && of == object;
    if (!goes_on) close();
    if (json.size() > 1) json += ", ";
    if (!goes_on && !of.empty()) json += quoted(of) + ": {";
    object = of;
    json += quoted(of.empty() ? name : name.substr(dot + 1)) + ": " + value;
  }
  close();
  return json + "}";
}

std::string sentence(const Ledger& ledger) {
  std::string text = "received " + std::to_string(ledger.received) + " =";
  bool is_first = true;
  for (const auto& [name, line] : kLines) {
    if (ledger.*line == 0) continue;
    text += std::string(is_first ? " " : " + ") + name + " " + std::to_string(ledger.*line);
    is_first = false;
  }
  if (is_first) text += " 0";
  return text + (ledger.balanced() ? "" : " (does not add up)");
}

}  // namespace asap::ros
