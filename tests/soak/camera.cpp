#include "camera.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/random.hpp"
#include "measure.hpp"

namespace asap::soak {

Camera::Camera(std::size_t largest_packet, std::uint64_t seed) : events_(largest_packet) {
  const CounterRandom random(seed);
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const std::uint64_t bits = random(i);
    events_[i].x = static_cast<std::uint16_t>((bits & 0xffff) * kWidth >> 16);
    events_[i].y = static_cast<std::uint16_t>((bits >> 16 & 0xffff) * kHeight >> 16);
    events_[i].p = static_cast<std::int16_t>(bits >> 63);
  }
}

std::span<Event> Camera::packet(std::size_t count, std::int64_t span_us) noexcept {
  const double step_us = static_cast<double>(span_us) / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    events_[i].t = now_us_ + static_cast<std::int64_t>(step_us * static_cast<double>(i));
  }
  now_us_ += span_us;
  return {events_.data(), count};
}

Camera::Pushed Camera::push_paced(Pipeline& pipeline, double events_per_s, double seconds) {
  constexpr std::chrono::milliseconds kPacket(1);
  const auto count = static_cast<std::size_t>(events_per_s * 1e-3);
  const auto packets = static_cast<std::int64_t>(seconds * 1e3);
  const auto start = Steady::now();
  Pushed pushed;
  for (std::int64_t i = 1; i <= packets; ++i) {
    const EventSpan events = packet(count, 1000);
    std::this_thread::sleep_until(start + i * kPacket);
    const double cpu_s = thread_cpu_s();
    const auto before = Steady::now();
    if (!pipeline.push(events)) break;
    const auto after = Steady::now();
    pushed.cpu_s += thread_cpu_s() - cpu_s;
    pushed.events += count;
    const auto in_s = [](Steady::duration time) {
      return std::chrono::duration<double>(time).count();
    };
    pushed.longest_s = std::max(pushed.longest_s, in_s(after - before));
    pushed.late_s = std::max(pushed.late_s, in_s(before - (start + i * kPacket)));
  }
  return pushed;
}

}  // namespace asap::soak
