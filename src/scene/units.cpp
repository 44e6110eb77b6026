#include "scene/units.hpp"

#include <array>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <span>

namespace palpate {
namespace {

int exponent_in(std::span<const UnitName> known, std::string_view name) {
  for (const UnitName& unit : known) {
    if (unit.name == name) return unit.exponent;
  }
  return 0;
}

/// 10^n, n >= 0: exact up to 22.
double power_of_ten(int n) {
  double power = 1.0;
  for (int i = 0; i < n; ++i) power *= 10.0;
  return power;
}

double times_power_of_ten(double value, int exponent) {
  return exponent >= 0 ? value * power_of_ten(exponent) : value / power_of_ten(-exponent);
}

struct SiUnit {
  Dimension dimension;
  std::string_view name;
  int exponent = 0;  ///< relative to a gram, since the kilogram already has a prefix
};

/// The name of a unit, and its size in SI units.
SiUnit si_unit(const Dimension& d) {
  constexpr std::array named{SiUnit{dimension::mass, "g", -3},
                             SiUnit{dimension::length, "m"},
                             SiUnit{dimension::time, "s"},
                             SiUnit{dimension::speed, "m/s"},
                             SiUnit{dimension::acceleration, "m/s^2"},
                             SiUnit{dimension::force, "N"},
                             SiUnit{dimension::pressure, "Pa"},
                             SiUnit{dimension::stiffness, "N/m"},
                             SiUnit{dimension::torque, "N m"},
                             SiUnit{dimension::energy, "J"}};
  for (const SiUnit& unit : named) {
    if (unit.dimension == d) return unit;
  }
  return {d, ""};
}

constexpr int lowest_prefix = -12;
constexpr std::array<std::string_view, 8> prefixes{"p", "n", "u", "m", "", "k", "M", "G"};

/// The SI prefix for 10^exponent; empty if there is none.
std::string_view prefix_of(int exponent, bool& known) {
  const int place = (exponent - lowest_prefix) / 3;
  known = exponent % 3 == 0 && exponent >= lowest_prefix && place < static_cast<int>(prefixes.size());
  return known ? prefixes[static_cast<std::size_t>(place)] : std::string_view{};
}

/// A power of a length unit: "mm^2", "mm", "".
std::string power_text(const std::string& unit, int power) {
  if (power == 0) return "";
  return power == 1 ? unit : fmt::format("{}^{}", unit, power);
}

/// A unit in the numerator and denominator: "g mm/s^2", "g/mm s^2".
std::string product(const Units& units, const Dimension& d) {
  std::string above;
  std::string below;
  for (const auto& [unit, power] :
       {std::pair(units.mass, d.mass), std::pair(units.length, d.length), std::pair(units.time, d.time)}) {
    if (power == 0) continue;
    std::string& side = power > 0 ? above : below;
    if (!side.empty()) side += ' ';
    side += power_text(unit, std::abs(power));
  }
  if (below.empty()) return above;
  const bool several = below.find(' ') != std::string::npos;
  return (above.empty() ? "1" : above) + "/" + (several ? "(" + below + ")" : below);
}

}  // namespace

int exponent_of(const Units& units, const Dimension& d) {
  return d.mass * exponent_in(mass_units, units.mass) + d.length * exponent_in(length_units, units.length) +
         d.time * exponent_in(time_units, units.time);
}

double to_si(double value, const Units& units, const Dimension& d) {
  return times_power_of_ten(value, exponent_of(units, d));
}
double from_si(double value, const Units& units, const Dimension& d) {
  return times_power_of_ten(value, -exponent_of(units, d));
}

std::string unit_name(const Units& units, const Dimension& d) {
  if (d == Dimension{}) return "";
  const SiUnit unit = si_unit(d);
  const bool basic = d == dimension::mass || d == dimension::length || d == dimension::time ||
                     d == dimension::speed || d == dimension::acceleration || unit.name.empty();
  if (basic) return product(units, d);
  const int exponent = exponent_of(units, d);
  if (units == Units{}) return std::string(unit.name);
  bool known = false;
  const std::string_view prefix = prefix_of(exponent, known);
  const std::string worked_out =
      known ? fmt::format("{}{}", prefix, unit.name) : fmt::format("1e{} {}", exponent, unit.name);
  return fmt::format("{} = {}", product(units, d), worked_out);
}

UnitForPeople unit_for_people(double size, const Units& units, const Dimension& d) {
  if (d == Dimension{}) return {};
  const SiUnit unit = si_unit(d);
  const int to_base = exponent_of(units, d) - unit.exponent;
  if (unit.name.empty()) return {times_power_of_ten(1.0, to_base), product(Units{}, d)};
  // Rounded to four digits, 999.96 becomes 1.000 with the next prefix.
  constexpr double rounds_up = 999.95;
  const int highest = lowest_prefix + 3 * (static_cast<int>(prefixes.size()) - 1);
  const bool plain = size == 0.0 || !std::isfinite(size);
  int exponent = plain ? 0 : lowest_prefix;
  while (!plain && exponent < highest && std::abs(times_power_of_ten(size, to_base - exponent)) >= rounds_up)
    exponent += 3;
  bool known = false;
  const std::string_view prefix = prefix_of(exponent, known);
  return {times_power_of_ten(1.0, to_base - exponent), fmt::format("{}{}", prefix, unit.name)};
}

std::string in_words(double value, const Units& units, const Dimension& d) {
  const UnitForPeople unit = unit_for_people(value, units, d);
  const std::string number = fmt::format("{:.4g}", unit.factor * value);
  return unit.name.empty() ? number : number + " " + unit.name;
}

}  // namespace palpate
