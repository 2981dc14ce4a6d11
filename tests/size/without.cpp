// What a program takes without ASAP: a thread, a string and an exception.
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>

int main(int count, char** words) {
  std::string text = words[0];
  std::thread worker([&] { text += std::to_string(count); });
  worker.join();
  try {
    if (count > 1) throw std::runtime_error(text);
  } catch (const std::exception& error) {
    std::puts(error.what());
  }
}
