#include "scene/suggest.hpp"

#include <array>
#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::array<std::string_view, 4> known{"young_modulus", "poisson_ratio", "density", "box"};

TEST(NearestName, ForgivesTypicalMistakes) {
  EXPECT_EQ(nearest_name("young_modulos", known), "young_modulus");  // replaced
  EXPECT_EQ(nearest_name("densty", known), "density");               // dropped
  EXPECT_EQ(nearest_name("densitty", known), "density");             // doubled
  EXPECT_EQ(nearest_name("Poisson_Ratio", known), "poisson_ratio");  // case
  EXPECT_EQ(nearest_name("bxo", known), "box");                      // swapped: one edit, not two
}

TEST(NearestName, NamesNothingWhenNothingIsNear) {
  EXPECT_EQ(nearest_name("colour", known), std::nullopt);
  EXPECT_EQ(nearest_name("bob", std::array<std::string_view, 1>{"xyz"}), std::nullopt);
  EXPECT_EQ(nearest_name("", known), std::nullopt);
  EXPECT_EQ(nearest_name(std::string(100000, 'a'), known), std::nullopt);
}

TEST(NearestName, TakesOfEqualsThatWithTheSameFirstLetterOrTheFirst) {
  EXPECT_EQ(nearest_name("cat", std::array<std::string_view, 3>{"bat", "hat", "rat"}), "bat");
  EXPECT_EQ(nearest_name("cat", std::array<std::string_view, 4>{"bat", "cut", "hat", "cot"}), "cut");
  EXPECT_EQ(nearest_name("vew", std::array<std::string_view, 3>{"new", "view", "run"}), "view");
}

TEST(ExpectedName, ListsAllWhenNothingIsNear) {
  EXPECT_EQ(expected_name("densty", known), "'density'");
  EXPECT_EQ(expected_name("zzz", known), "one of 'young_modulus', 'poisson_ratio', 'density', 'box'");
  EXPECT_EQ(expected_name("zzz", std::array<std::string_view, 1>{"linear"}), "'linear'");
  EXPECT_EQ(expected_name("1", std::array<std::string_view, 2>{"linear", "z"}), "one of 'linear', 'z'");
  EXPECT_EQ(expected_name("1", std::array<std::string_view, 3>{"a", "b", "a"}), "one of 'a', 'b'");
  EXPECT_EQ(expected_name("x", {}), "none");
  EXPECT_EQ(expected_name("Z", std::array<std::string_view, 2>{"linear", "z"}), "'z'");
}

}  // namespace
}  // namespace palpate
