#include "io/hash.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <span>
#include <vector>

namespace palpate::io {
namespace {

std::uint64_t hash_text(const char* text) {
  return fnv1a(std::as_bytes(std::span<const char>(text, std::strlen(text))));
}

TEST(Hash, PublishedValuesOfFnv1a) {
  EXPECT_EQ(hash_text(""), 0xcbf29ce484222325U);
  EXPECT_EQ(hash_text("a"), 0xaf63dc4c8601ec8cU);
  EXPECT_EQ(hash_text("foobar"), 0x85944171f73967e8U);
}

TEST(StateHash, KnownState) {  // by a few lines of Python: struct.pack('<12d', ...), FNV-1a
  const std::vector<Vec3> positions{{0, 0.5, -1.25}, {3, 1e-3, 7}};
  const std::vector<Vec3> velocities{{1, -0.0, 2}, {0.1, 0.2, 0.3}};
  EXPECT_EQ(state_hash(positions, velocities), "afd126ec513c6b86");
}

TEST(StateHash, KeepsLeadingZeros) {  // same origin
  EXPECT_EQ(state_hash(std::vector<Vec3>{{1029, 0, 0}}, std::vector<Vec3>{{0, 0, 0}}), "008cd05902fe54b9");
}

TEST(StateHash, SeesOneBitAndTheOrder) {
  const std::vector<Vec3> a{{1, 2, 3}};
  const std::vector<Vec3> zero{{0, 0, 0}};
  const std::vector<Vec3> negative_zero{{0, 0, -0.0}};
  EXPECT_NE(state_hash(a, zero), state_hash(a, negative_zero));
  EXPECT_NE(state_hash(a, zero), state_hash(zero, a));
  EXPECT_EQ(state_hash(a, zero), state_hash(std::vector<Vec3>{{1, 2, 3}}, zero));
}

}  // namespace
}  // namespace palpate::io
