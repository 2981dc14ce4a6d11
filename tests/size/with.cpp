// The same with a live pipeline: a worker under Deadline, and a thread that pushes.
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>

#include "asap/runner/pipeline.hpp"

int main(int count, char** words) {
  std::string text = words[0];
  std::size_t seen = 0;
  try {
    asap::Pipeline pipeline{{.latency = std::chrono::milliseconds(10), .log_rows = 0},
                            [&](asap::EventSpan events) { seen += events.size(); }};
    const asap::Event events[2]{{1, 2, 1, 3}, {4, 5, 0, count + 3}};
    std::thread driver([&] { pipeline.push(events); });
    driver.join();
    pipeline.stop();
    pipeline.join();
    text += ": " + std::to_string(seen) + " events";
  } catch (const std::exception& error) {
    text = error.what();
  }
  std::puts(text.c_str());
}
