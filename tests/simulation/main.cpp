// simulation: runs the library in virtual time under a seeded scheduler with faults, and holds it
// to its laws at every step.
//
//   simulation --seeds 0..9999 [--jobs 2]               a range; exit 1 if a seed fails
//   simulation --seeds sample                           200 of them; ASAP_LONG_TESTS=1: 10,000
//   simulation --life live ...                          a whole live pipeline instead of its parts
//   simulation --seed 17 [--faults 5] [--until 1234]    one seed, its setup and its last steps
//   simulation --golden FILE                            fingerprints of known runs; exit 1 if
//                                                       one differs
//   simulation --fingerprints 20                        prints such a file
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>

#include "search.hpp"

namespace asap::simulation {
namespace {

struct Options {
  std::string_view seeds;
  std::string_view seed;
  std::string_view golden;
  bool live = false;
  unsigned faults = kAllFaults;
  std::uint64_t until = kToTheEnd;
  std::uint64_t fingerprints = 0;
  unsigned jobs = std::max(1U, std::thread::hardware_concurrency());
};

template <class Number>
bool parse(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    const std::string_view value = argv[i + 1];
    bool ok = true;
    if (name == "--seeds") {
      options.seeds = value;
    } else if (name == "--seed") {
      options.seed = value;
    } else if (name == "--golden") {
      options.golden = value;
    } else if (name == "--life") {
      ok = value == "live" || value == "parts";
      options.live = value == "live";
    } else if (name == "--faults") {
      ok = parse(value, options.faults);
    } else if (name == "--until") {
      ok = parse(value, options.until);
    } else if (name == "--fingerprints") {
      ok = parse(value, options.fingerprints);
    } else if (name == "--jobs") {
      ok = parse(value, options.jobs) && options.jobs > 0;
    } else {
      ok = false;
    }
    if (!ok) return false;
  }
  return argc > 1 && argc % 2 == 1;
}

bool are_long() {
  const char* const asked = std::getenv("ASAP_LONG_TESTS");
  return asked != nullptr && std::string_view(asked) == "1";
}

int run_range(const Options& options) {
  const std::size_t dots = options.seeds.find("..");
  SearchConfig config{.jobs = options.jobs, .live = options.live};
  if (options.seeds == "sample") {
    config.last = are_long() ? 9999 : 199;
  } else if (dots == std::string_view::npos ||
             !parse(options.seeds.substr(0, dots), config.first) ||
             !parse(options.seeds.substr(dots + 2), config.last) || config.last < config.first) {
    std::fprintf(stderr, "--seeds %s: give FIRST..LAST\n", std::string(options.seeds).c_str());
    return 2;
  }
  const SearchResult sum = search(config);
  for (const std::uint64_t seed : sum.failures) {
    std::fputs(report(minimise({.seed = seed, .live = options.live})).c_str(), stdout);
  }
  std::printf(
      "%llu seeds, %llu events, %llu packages, %llu steps, recovery judged in %llu; "
      "%zu failed\n",
      static_cast<unsigned long long>(sum.seeds), static_cast<unsigned long long>(sum.events),
      static_cast<unsigned long long>(sum.packages), static_cast<unsigned long long>(sum.steps),
      static_cast<unsigned long long>(sum.judged), sum.failures.size());
  return sum.failures.empty() ? 0 : 1;
}

int run_seed(const Options& options) {
  TrialConfig config{
      .faults = options.faults, .until = options.until, .fingerprint = true, .live = options.live};
  if (!parse(options.seed, config.seed)) return 2;
  const TrialResult result = run_trial(config);
  std::fputs((result.report.empty() ? describe(config) : result.report).c_str(), stdout);
  std::printf("%llu events, %llu packages, %llu steps, %s\n",
              static_cast<unsigned long long>(result.events),
              static_cast<unsigned long long>(result.packages),
              static_cast<unsigned long long>(result.steps), result.fingerprint.c_str());
  return result.failed ? 1 : 0;
}

// Lines of: seed, fingerprint.
int compare(const Options& options) {
  std::ifstream file{std::string(options.golden)};
  std::uint64_t seed = 0;
  std::string wanted;
  std::uint64_t compared = 0;
  int different = 0;
  for (; file >> seed >> wanted; ++compared) {
    const TrialResult result = run_trial({.seed = seed, .fingerprint = true});
    if (!result.failed && result.fingerprint == wanted) continue;
    ++different;
    std::printf("seed %llu: %s, wanted %s\n", static_cast<unsigned long long>(seed),
                result.fingerprint.c_str(), wanted.c_str());
  }
  std::printf("%llu compared, %d different\n", static_cast<unsigned long long>(compared),
              different);
  return compared > 0 && different == 0 ? 0 : 1;
}

int print_fingerprints(std::uint64_t count) {
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    const TrialResult result = run_trial({.seed = seed, .fingerprint = true});
    std::printf("%llu %s\n", static_cast<unsigned long long>(seed), result.fingerprint.c_str());
  }
  return 0;
}

int run(int argc, char** argv) {
  Options options;
  if (parse(argc, argv, options)) {
    if (!options.seeds.empty()) return run_range(options);
    if (!options.seed.empty()) return run_seed(options);
    if (!options.golden.empty()) return compare(options);
    if (options.fingerprints > 0) return print_fingerprints(options.fingerprints);
  }
  std::fputs(
      "usage: simulation --seeds A..B|sample [--jobs J] | --seed N [--faults MASK] [--until STEP]\n"
      "       | --golden FILE | --fingerprints N; --life live|parts before it\n",
      stderr);
  return 2;
}

}  // namespace
}  // namespace asap::simulation

int main(int argc, char** argv) { return asap::simulation::run(argc, argv); }
