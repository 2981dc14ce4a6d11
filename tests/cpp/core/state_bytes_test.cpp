#include "core/state_bytes.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "asap/version.hpp"

namespace asap::state_bytes_test {
namespace {

struct Inner {
  std::vector<int> values;
  double weight = 0;

  static auto saved(auto& self) noexcept { return std::tie(self.values, self.weight); }
};

class Object {
 public:
  explicit Object(int width) : width_(width) { inner_.values.reserve(4); }

  void take(int value) {
    inner_.values.push_back(value);
    inner_.weight += 0.5;
    full_ = inner_.values.size() == 4;
  }

  std::vector<std::byte> state() const { return state_bytes("Object", *this, count); }
  void restore(std::span<const std::byte> bytes) { restore_state("Object", bytes, *this, count); }

  static auto saved(auto& self) {
    return std::tuple_cat(same(self.width_, std::vector{self.width_}),
                          std::tie(self.inner_, self.full_));
  }

  const Inner& inner() const noexcept { return inner_; }
  bool full() const noexcept { return full_; }
  int count = 0;

 private:
  int width_;
  Inner inner_;
  bool full_ = false;
};

std::string refusal(Object& object, std::span<const std::byte> bytes) {
  try {
    object.restore(bytes);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(StateBytes, RestoreWhatWasWritten) {
  Object one(3);
  for (int i = 1; i <= 4; ++i) one.take(i);
  one.count = 9;
  Object other(3);
  other.take(7);
  other.restore(one.state());
  EXPECT_EQ(other.inner().values, (std::vector{1, 2, 3, 4}));
  EXPECT_EQ(other.inner().weight, 2);
  EXPECT_TRUE(other.full());
  EXPECT_EQ(other.count, 9);
  EXPECT_EQ(other.state(), one.state());
  other.restore(Object(3).state());
  EXPECT_TRUE(other.inner().values.empty());
  EXPECT_EQ(other.inner().values.capacity(), 4);
}

TEST(StateBytes, RefuseAnotherConfiguration) {
  Object other(4);
  EXPECT_EQ(refusal(other, Object(3).state()),
            "state = of another Object: make it with the parameters of the one that wrote it");
}

TEST(StateBytes, RefuseAnotherName) {
  Object object(3);
  EXPECT_EQ(refusal(object, state_bytes("Other", object)), "state = of Other: this is Object");
}

TEST(StateBytes, RefuseVectorsThatDoNotFit) {
  Object large(3);
  for (int i = 0; i < 5; ++i) large.take(i);
  Object small(3);
  EXPECT_NE(refusal(small, large.state()), "");
}

TEST(StateBytes, RefuseMoreAndLessThanTheObjectHas) {
  Object object(3);
  EXPECT_NE(refusal(object, state_bytes("Object", object)), "");
  EXPECT_NE(refusal(object, state_bytes("Object", object, 1, 2)), "");
}

TEST(StateBytes, RefuseWhateverWasChangedAndRestoreNothing) {
  Object one(3);
  one.take(5);
  const auto bytes = one.state();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto altered = bytes;
    altered[i] ^= std::byte{4};
    EXPECT_NE(refusal(one, altered), "") << i;
    EXPECT_NE(refusal(one, std::span(bytes).first(i)), "") << i;
  }
  EXPECT_EQ(one.state(), bytes);
}

}  // namespace
}  // namespace asap::state_bytes_test
