#include "asap/schemes/scheme.hpp"

#include <gtest/gtest.h>

namespace asap::parameters_test {
namespace {

struct Config {
  double share = 0.5;
  std::size_t size = 7;
  std::optional<double> limit{};
  double unlisted = 1.0;

  static constexpr std::tuple kParameters{
      NamedField{"size", &Config::size},
      NamedField{"limit", &Config::limit},
      NamedField{"share", &Config::share},
  };
};

TEST(Parameters, AreListedInTheOrderOfTheTable) {
  EXPECT_EQ(parameters_of(Config{.limit = 2.0}),
            (SchemeParameters{{"size", std::int64_t{7}}, {"limit", 2.0}, {"share", 0.5}}));
}

TEST(Parameters, LeaveOutWhatHasNoValue) {
  EXPECT_EQ(parameters_of(Config{.share = 0.25, .size = std::size_t{1} << 40}),
            (SchemeParameters{{"size", std::int64_t{1} << 40}, {"share", 0.25}}));
}

TEST(Parameters, TableOfFieldsIsKnownToTheCompiler) {
  constexpr auto field = std::get<0>(Config::kParameters);
  static_assert(field.name == std::string_view("size"));
  static_assert(Config{}.*field.field == 7);
}

}  // namespace
}  // namespace asap::parameters_test
