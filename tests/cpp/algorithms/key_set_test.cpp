#include "algorithms/key_set.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace key_set_test {
namespace {

using asap::KeySet;

std::vector<int> elements(const KeySet& set) {
  std::vector<int> keys;
  set.for_each([&](KeySet::Key key) { keys.push_back(key); });
  return keys;
}

TEST(KeySet, HoldsKeysOfBothWords) {
  KeySet set;
  EXPECT_TRUE(set.empty());
  for (const int key : {127, 64, 0, 63}) set.insert(static_cast<KeySet::Key>(key));
  EXPECT_EQ(elements(set), (std::vector<int>{0, 63, 64, 127}));
  set.erase(0);
  set.erase(63);
  EXPECT_EQ(set.lowest(), 64);
  set.erase(64);
  EXPECT_EQ(elements(set), (std::vector<int>{127}));
  EXPECT_FALSE(set.empty());
}

TEST(KeySet, UnitesBothWords) {
  KeySet a;
  KeySet b;
  a.insert(3);
  b.insert(4);
  b.insert(100);
  a |= b;
  EXPECT_EQ(elements(a), (std::vector<int>{3, 4, 100}));
}

TEST(KeySet, AllIsEveryKey) {
  EXPECT_EQ(elements(KeySet::all()).size(), KeySet::kKeys);
  EXPECT_EQ(KeySet::all().lowest(), 0);
}

}  // namespace
}  // namespace key_set_test
