// Units that are worked out. Oracle: the definitions of the units.
#include "scene/units.hpp"

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Units si;
const Units medical{"mm", "g", "s"};
const Units tonnes{"mm", "t", "s"};
const Units odd{"cm", "kg", "ms"};

TEST(Units, AreMultiplesOfTheSi) {
  EXPECT_EQ(to_si(5.33e6, medical, dimension::force), 5.33);
  EXPECT_EQ(to_si(2.0, medical, dimension::pressure), 2.0);
  EXPECT_EQ(to_si(3.0, tonnes, dimension::pressure), 3e6);
  EXPECT_EQ(to_si(3.0, tonnes, dimension::force), 3.0);
  EXPECT_EQ(to_si(1.0, odd, dimension::force), 1e4);  // kg cm/ms^2 = 1e-2 / 1e-6 N
  EXPECT_EQ(to_si(1.0, odd, dimension::speed), 10.0);
  for (const Units& units : {si, medical, tonnes, odd}) {
    for (const Dimension& d : {dimension::force, dimension::energy, dimension::density, dimension::none})
      EXPECT_DOUBLE_EQ(from_si(to_si(0.7, units, d), units, d), 0.7);
  }
}

TEST(Units, HaveNamesThatSayWhatTheyAre) {
  EXPECT_EQ(unit_name(si, dimension::force), "N");
  EXPECT_EQ(unit_name(si, dimension::energy), "J");
  EXPECT_EQ(unit_name(si, dimension::speed), "m/s");
  EXPECT_EQ(unit_name(medical, dimension::force), "g mm/s^2 = uN");
  EXPECT_EQ(unit_name(medical, dimension::pressure), "g/(mm s^2) = Pa");
  EXPECT_EQ(unit_name(medical, dimension::energy), "g mm^2/s^2 = nJ");
  EXPECT_EQ(unit_name(medical, dimension::torque), "g mm^2/s^2 = nN m");
  EXPECT_EQ(unit_name(medical, dimension::stiffness), "g/s^2 = mN/m");
  EXPECT_EQ(unit_name(medical, dimension::length), "mm");
  EXPECT_EQ(unit_name(tonnes, dimension::pressure), "t/(mm s^2) = MPa");
  EXPECT_EQ(unit_name(odd, dimension::force), "kg cm/ms^2 = 1e4 N");
  EXPECT_EQ(unit_name(odd, dimension::none), "");
}

TEST(Units, OfPeopleHaveThePrefixThatSuits) {
  EXPECT_EQ(in_words(5.33e6, medical, dimension::force), "5.33 N");
  EXPECT_EQ(in_words(-12345.0, medical, dimension::pressure), "-12.35 kPa");
  EXPECT_EQ(in_words(999.96, si, dimension::pressure), "1 kPa");
  EXPECT_EQ(in_words(999.94, si, dimension::pressure), "999.9 Pa");
  EXPECT_EQ(in_words(2.5e-3, si, dimension::energy), "2.5 mJ");
  EXPECT_EQ(in_words(0.5, medical, dimension::length), "500 um");
  EXPECT_EQ(in_words(20.0, medical, dimension::mass), "20 g");
  EXPECT_EQ(in_words(0.0, si, dimension::force), "0 N");
  EXPECT_EQ(in_words(0.25, si, dimension::none), "0.25");
  const UnitForPeople unit = unit_for_people(15000.0, medical, dimension::pressure);
  EXPECT_EQ(unit.name, "kPa");
  EXPECT_DOUBLE_EQ(unit.factor * 15000.0, 15.0);
}

}  // namespace
}  // namespace palpate
