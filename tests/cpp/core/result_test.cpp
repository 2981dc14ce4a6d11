#include "asap/core/result.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

namespace asap::result_test {
namespace {

struct Pinned {
  explicit Pinned(int given) : number(given) {}
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;
  int number;
};

TEST(Result, HoldsAnObject) {
  const Result<Pinned> result(std::make_unique<Pinned>(7));
  ASSERT_TRUE(result);
  EXPECT_EQ((*result).number, 7);
  EXPECT_EQ(result->number, 7);
  EXPECT_EQ(result.message(), "");
}

TEST(Result, OrAnError) {
  const Result<Pinned> result(Error{.message = "speed = -1: must be at least 0", .field = "speed"});
  EXPECT_FALSE(result);
  EXPECT_EQ(result.message(), "speed = -1: must be at least 0");
  EXPECT_EQ(result.error().field, "speed");
}

TEST(Result, IsEmptyAtFirstAndGivesItsObjectAway) {
  Result<Pinned> result;
  EXPECT_FALSE(result);
  EXPECT_EQ(result.message(), "");
  EXPECT_EQ(result.release(), nullptr);
  result = Result<Pinned>(std::make_unique<Pinned>(7));
  const std::unique_ptr<Pinned> taken = result.release();
  EXPECT_EQ(taken->number, 7);
  EXPECT_FALSE(result);
}

TEST(Result, AnObjectKeepsItsAddressWhenItMoves) {
  Result<Pinned> from(std::make_unique<Pinned>(7));
  const Pinned* const address = &*from;
  const Result<Pinned> to = std::move(from);
  EXPECT_EQ(&*to, address);
  static_assert(std::is_nothrow_move_constructible_v<Result<Pinned>>);
  static_assert(!std::is_convertible_v<Result<Pinned>, bool>);  // explicit: it is no number
}

}  // namespace
}  // namespace asap::result_test
