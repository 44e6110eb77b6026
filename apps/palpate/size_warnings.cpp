#include "size_warnings.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

#include "geometry/vector.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "scene/units.hpp"

namespace palpate::app {
namespace {

constexpr double longest = 5.0;      // m
constexpr double shortest = 0.2e-3;  // m
constexpr double heaviest = 2000.0;  // kg

/// Size and mass of a body, in SI units.
struct BodySize {
  std::string name;
  double length = 0.0;  ///< longest side of its box
  double mass = 0.0;

  /// By how much the size exceeds what is likely, as a ratio; up to 1 there is no warning.
  [[nodiscard]] double strangeness() const {
    return std::max({length / longest, shortest / std::max(length, 1e-300), mass / heaviest});
  }
};

BodySize size_of(const Model& model, Index body, const Units& units) {
  const MeshStatistics statistics = mesh_statistics(model.bodies, model.bodies.points_rest(), body);
  const Vec3 sides = statistics.upper - statistics.lower;
  return {.name = at(model.bodies.bodies(), body).name,
          .length = to_si(std::max({sides.x, sides.y, sides.z}), units, dimension::length),
          .mass = to_si(statistics.volume * at(model.materials, body).density, units, dimension::mass)};
}

std::string two_digits(double value) {
  constexpr double hundred = 100.0;
  constexpr double million = 1e6;
  return hundred <= value && value < million ? fmt::format("{:.0f}", value) : fmt::format("{:.2g}", value);
}

std::string warning_of(const BodySize& body) {
  const char* const side = body.length < shortest ? "larger" : "smaller";
  return fmt::format(
      "'{}' is {} long and weighs {}: is its mesh in other units than the scene? "
      "The body's \"scale\" makes it {}",
      shown_name(body.name), length_text(body.length), mass_text(body.mass), side);
}

}  // namespace

void warn_of_sizes(const Scene& scene, const Model& model) {
  BodySize strangest;
  double most = 1.0;
  std::size_t others = 0;
  for (Index body = 0; body < model.bodies.body_count(); ++body) {
    if (at(model.obstacles, body) != 0) continue;
    BodySize size = size_of(model, body, scene.units);
    const double strangeness = size.strangeness();
    if (strangeness > 1.0) ++others;
    if (strangeness <= most) continue;
    most = strangeness;
    strangest = std::move(size);
  }
  if (others == 0) return;
  say_warning(warning_of(strangest) +
              (others > 1
                   ? fmt::format(" (so with {})",
                                 others == 2 ? "another body" : fmt::format("{} other bodies", others - 1))
                   : ""));
}

void warn_of_size(const std::string& file, double side, const MeshUnit& unit) {
  const double meters = unit.meters * side;
  if (shortest <= meters && meters <= longest) return;
  const MeshUnit likely = guess_unit(side);
  const std::string other =
      likely.name.empty() || likely.name == unit.name
          ? ""
          : fmt::format(" In {} it is {}", likely.name, length_text(likely.meters * side));
  say_warning(
      fmt::format("'{}' is {} long in {}: is that its unit?{}", file, length_text(meters), unit.name, other));
}

std::string length_text(double meters) {
  constexpr double small = 0.01;
  constexpr double tiny = 1e-5;
  if (meters < tiny) return two_digits(1e6 * meters) + " um";
  return meters < small ? two_digits(1e3 * meters) + " mm" : two_digits(meters) + " m";
}

std::string mass_text(double kilogrammes) {
  constexpr double heavy = 1000.0;
  constexpr double light = 0.1;
  constexpr double tiny = 1e-4;
  if (kilogrammes >= heavy) return two_digits(1e-3 * kilogrammes) + " tonnes";
  if (kilogrammes >= light) return two_digits(kilogrammes) + " kg";
  return kilogrammes >= tiny ? two_digits(1e3 * kilogrammes) + " g" : two_digits(1e6 * kilogrammes) + " mg";
}

}  // namespace palpate::app
