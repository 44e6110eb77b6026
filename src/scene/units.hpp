#pragma once

#include <array>
#include <string>
#include <string_view>

/// Units of a scene. All numbers of a scene and of the files of its run are in these units. Summaries for
/// people are in N, Pa, J, m and so on.
namespace palpate {

/// The units of all numbers of a scene.
struct Units {
  std::string length = "m";
  std::string mass = "kg";
  std::string time = "s";
  friend bool operator==(const Units&, const Units&) = default;
};

/// A unit and its size in SI units, 10^exponent.
struct UnitName {
  std::string_view name;
  int exponent;
};
inline constexpr std::array length_units{UnitName{"m", 0}, UnitName{"cm", -2}, UnitName{"mm", -3},
                                         UnitName{"um", -6}, UnitName{"km", 3}};
inline constexpr std::array mass_units{UnitName{"kg", 0}, UnitName{"g", -3}, UnitName{"mg", -6},
                                       UnitName{"ug", -9}, UnitName{"t", 3}};
inline constexpr std::array time_units{UnitName{"s", 0}, UnitName{"ms", -3}, UnitName{"us", -6}};

/// A product of powers of mass, length and time.
struct Dimension {
  int mass = 0;
  int length = 0;
  int time = 0;
  bool is_torque = false;  ///< a torque has the dimension of an energy, but another unit
  friend bool operator==(const Dimension&, const Dimension&) = default;
};

namespace dimension {
inline constexpr Dimension none{};
inline constexpr Dimension mass{1, 0, 0};
inline constexpr Dimension length{0, 1, 0};
inline constexpr Dimension area{0, 2, 0};
inline constexpr Dimension volume{0, 3, 0};
inline constexpr Dimension time{0, 0, 1};
inline constexpr Dimension speed{0, 1, -1};
inline constexpr Dimension acceleration{0, 1, -2};
inline constexpr Dimension force{1, 1, -2};
inline constexpr Dimension torque{1, 2, -2, true};
inline constexpr Dimension energy{1, 2, -2};
inline constexpr Dimension pressure{1, -1, -2};
inline constexpr Dimension density{1, -3, 0};
inline constexpr Dimension stiffness{1, 0, -2};
}  // namespace dimension

/// One unit of a scene is 10^(result) SI units. Unknown units are treated as SI units.
[[nodiscard]] int exponent_of(const Units& units, const Dimension& dimension);
/// Converts a number of a scene to SI, or back. Both round once.
[[nodiscard]] double to_si(double value, const Units& units, const Dimension& dimension);
[[nodiscard]] double from_si(double value, const Units& units, const Dimension& dimension);

/// The name of a scene's unit: "N" in SI, otherwise "g mm/s^2 = uN", or "kg cm/s^2 = 1e-2 N" where no prefix
/// fits. ASCII. Empty for a dimensionless number.
[[nodiscard]] std::string unit_name(const Units& units, const Dimension& dimension);
/// The unit of display for numbers of about this size: a number of the scene times `factor` is in this unit.
struct UnitForPeople {
  double factor = 1.0;
  std::string name;  ///< "kPa"; ASCII, empty for a pure number
};
[[nodiscard]] UnitForPeople unit_for_people(double size, const Units& units, const Dimension& dimension);
/// A number of a scene as text, in SI with a suitable prefix: "5.33 N", "12 kPa". Four digits.
[[nodiscard]] std::string in_words(double value, const Units& units, const Dimension& dimension);

}  // namespace palpate
