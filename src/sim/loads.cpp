#include "sim/loads.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/triangle.hpp"
#include "mesh/unused_points.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

constexpr const char* not_finite = "a number that is not finite";

void check_count(const char* source, const std::string& where, std::size_t found, std::size_t expected) {
  if (found != expected)
    throw Error(source, where, std::to_string(found) + " values", std::to_string(expected));
}

void check_index(const char* source, const std::string& where, Index found, std::size_t count) {
  if (found < 0 || static_cast<std::size_t>(found) >= count)
    throw Error(source, where, std::to_string(found), "0 to " + std::to_string(count - 1));
}

void check_finite(const char* source, const std::string& where, const Vec3& value) {
  if (!is_finite(value)) throw Error(source, where, not_finite, "three finite numbers");
}

std::string element(const char* name, std::size_t i) {
  return std::string(name).append(1, '[').append(std::to_string(i)).append(1, ']');
}

void check_ramp(const Ramp& ramp, const std::string& where) {
  check_count("loads", where + ".factors", ramp.factors.size(), ramp.times.size());
  for (std::size_t i = 0; i < ramp.times.size(); ++i) {
    if (!std::isfinite(ramp.times[i]) || !std::isfinite(ramp.factors[i]))
      throw Error("loads", where, not_finite, "finite numbers");
    if (i > 0 && ramp.times[i] <= ramp.times[i - 1]) {
      throw Error("loads", element((where + ".times").c_str(), i), number_text(ramp.times[i]),
                  "more than the time before, " + number_text(ramp.times[i - 1]));
    }
  }
}

void check_soft(const char* source, const std::string& where, Index triangle, const Bodies& bodies,
                std::span<const std::uint8_t> rigid) {
  check_index(source, where, triangle, bodies.triangles().size());
  const Index body = bodies.body_of(at(bodies.triangles(), triangle));
  if (at(rigid, body) != 0) {
    throw Error(source, where,
                "triangle " + std::to_string(triangle) + " of the rigid body '" +
                    at(bodies.bodies(), body).name + "'",
                "a triangle of a body that deforms");
  }
}

void check_load(const SurfaceLoad& load, const std::string& where, const Bodies& bodies,
                std::span<const std::uint8_t> rigid) {
  std::vector<Index> sorted = load.triangles;
  std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted);
  if (twice != sorted.end()) {
    throw Error("loads", where + ".triangles", "triangle " + std::to_string(*twice) + " twice",
                "each triangle once");
  }
  for (std::size_t i = 0; i < load.triangles.size(); ++i)
    check_soft("loads", element((where + ".triangles").c_str(), i), load.triangles[i], bodies, rigid);
  if (!std::isfinite(load.pressure)) throw Error("loads", where + ".pressure", not_finite, "a finite number");
  check_finite("loads", where + ".traction", load.traction);
  check_ramp(load.ramp, where + ".ramp");
}

/// Adds a uniform load on a triangle: equal parts on its three corners.
void add_to_corners(const Triangle& t, const Vec3& force, std::vector<Vec3>& forces) {
  for (const Index corner : t) at(forces, corner) += (1.0 / 3.0) * force;
}

}  // namespace

double factor_at(const Ramp& ramp, double time) {
  if (ramp.times.empty()) return 1.0;
  const auto next = std::ranges::upper_bound(ramp.times, time);
  if (next == ramp.times.begin()) return ramp.factors.front();
  if (next == ramp.times.end()) return ramp.factors.back();
  const auto i = static_cast<std::size_t>(next - ramp.times.begin());
  const double fraction = (time - ramp.times[i - 1]) / (ramp.times[i] - ramp.times[i - 1]);
  return (1.0 - fraction) * ramp.factors[i - 1] + fraction * ramp.factors[i];
}

double end_of(const Ramp& ramp) {
  std::size_t last = ramp.times.size();
  while (last > 1 && ramp.factors[last - 1] == ramp.factors[last - 2]) --last;
  return last > 1 ? ramp.times[last - 1] : 0.0;
}

LoadSet loads_of(const Model& model) {
  return {.forces = model.forces,
          .pressures = {},
          .points = model.point_loads,
          .surfaces = model.surface_loads,
          .gravity = model.gravity_of_body};
}

namespace {

/// Whether all of these indices are in a range; false if none is. Throws Error if only some are.
bool all_in(const Range& range, const std::vector<Index>& items, const char* what) {
  const auto count = std::ranges::count_if(items, [&](Index i) { return range.begin <= i && i < range.end; });
  if (count == 0) return false;
  if (count == std::ssize(items)) return true;
  throw Error("model change", "loads", std::string("a load on ") + what + " of more than one body",
              "loads that act on one body each");
}

}  // namespace

void replace_loads(const BodyLoads& change, const Bodies& bodies, LoadSet& loads) {
  check_index("model change", "loads.body", change.body, bodies.bodies().size());
  const Body& body = at(bodies.bodies(), change.body);
  for (const PointLoad& load : change.points) {
    if (load.points.empty() || !all_in(body.points, load.points, "points")) {
      throw Error("model change", "loads", "a load without points of '" + body.name + "'",
                  "one or more of its points");
    }
  }
  for (const SurfaceLoad& load : change.surfaces) {
    if (load.triangles.empty() || !all_in(body.triangles, load.triangles, "triangles")) {
      throw Error("model change", "loads", "a load without triangles of '" + body.name + "'",
                  "one or more of its surface triangles");
    }
  }
  std::erase_if(loads.points,
                [&](const PointLoad& load) { return all_in(body.points, load.points, "points"); });
  std::erase_if(loads.surfaces,
                [&](const SurfaceLoad& load) { return all_in(body.triangles, load.triangles, "triangles"); });
  if (!loads.forces.empty())
    for (Index p = body.points.begin; p < body.points.end; ++p) at(loads.forces, p) = {};
  if (!loads.pressures.empty())
    for (Index t = body.triangles.begin; t < body.triangles.end; ++t) at(loads.pressures, t) = 0.0;
  loads.points.insert(loads.points.end(), change.points.begin(), change.points.end());
  loads.surfaces.insert(loads.surfaces.end(), change.surfaces.begin(), change.surfaces.end());
}

Loads::Loads(LoadSet loads, const Bodies& bodies, std::span<const std::uint8_t> obstacles,
             std::vector<std::uint8_t> ambient, std::span<const std::uint8_t> free,
             std::span<const double> masses)
    : rigid_(obstacles.begin(), obstacles.end()),
      takes_ambient_(std::move(ambient)),
      free_(free),
      masses_(masses),
      loads_(std::move(loads)) {
  const std::size_t points = bodies.points_rest().size();
  if (!loads_.forces.empty()) check_count("simulation", "forces", loads_.forces.size(), points);
  for (std::size_t p = 0; p < loads_.forces.size(); ++p) {
    if (is_finite(loads_.forces[p])) continue;
    throw Error("simulation", "forces", "a force on point " + std::to_string(p) + " that is not finite",
                "three finite numbers");
  }
  if (!loads_.gravity.empty())
    check_count("simulation", "gravity_of_body", loads_.gravity.size(), bodies.bodies().size());
  for (std::size_t b = 0; b < loads_.gravity.size(); ++b)
    check_finite("simulation", element("gravity_of_body", b), loads_.gravity[b].value_or(Vec3{}));
  for (std::size_t i = 0; i < loads_.points.size(); ++i) {
    const PointLoad& load = loads_.points[i];
    const std::string where = element("point_loads", i);
    if (load.points.empty()) throw Error("loads", where + ".points", "none", "one or more");
    for (const Index point : load.points) {
      check_index("loads", where + ".points", point, points);
      check_used(bodies, point, "loads", where + ".points");
    }
    check_finite("loads", where + ".force", load.force);
    check_ramp(load.ramp, where + ".ramp");
  }
  for (std::size_t i = 0; i < loads_.surfaces.size(); ++i)
    check_load(loads_.surfaces[i], element("surface_loads", i), bodies, rigid_);
}

void Loads::set_forces(std::span<const Index> points, std::span<const Vec3> forces) {
  check_count("simulation", "forces", forces.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] < 0 || static_cast<std::size_t>(points[i]) >= masses_.size()) {
      throw Error("simulation", "point", std::to_string(points[i]),
                  "less than " + std::to_string(masses_.size()));
    }
    if (!is_finite(forces[i])) throw Error("simulation", "force", not_finite, "three finite numbers");
  }
  if (loads_.forces.empty()) loads_.forces.resize(masses_.size());
  for (std::size_t i = 0; i < points.size(); ++i) at(loads_.forces, points[i]) = forces[i];
}

void Loads::set_pressure(const Bodies& bodies, std::span<const Index> triangles, double pressure) {
  if (!std::isfinite(pressure)) throw Error("simulation", "pressure", not_finite, "a finite number");
  for (const Index triangle : triangles) check_soft("simulation", "triangles", triangle, bodies, rigid_);
  if (loads_.pressures.empty()) loads_.pressures.resize(bodies.triangles().size());
  for (const Index triangle : triangles) at(loads_.pressures, triangle) = pressure;
}

void Loads::set_pressure(const Bodies& bodies, std::span<const Index> triangles,
                         std::span<const double> pressures) {
  check_count("simulation", "pressure", pressures.size(), triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    check_soft("simulation", "triangles", triangles[i], bodies, rigid_);
    if (!std::isfinite(pressures[i])) {
      throw Error("simulation", "pressure",
                  "a number that is not finite, for triangle " + std::to_string(triangles[i]),
                  "finite numbers");
    }
  }
  if (loads_.pressures.empty()) loads_.pressures.resize(bodies.triangles().size());
  for (std::size_t i = 0; i < triangles.size(); ++i) at(loads_.pressures, triangles[i]) = pressures[i];
}

void Loads::restore(std::vector<Vec3> forces, std::vector<double> pressures) {
  loads_.forces = std::move(forces);
  loads_.pressures = std::move(pressures);
}

double Loads::end() const {
  double last = 0.0;
  for (const PointLoad& load : loads_.points) last = std::max(last, end_of(load.ramp));
  for (const SurfaceLoad& load : loads_.surfaces) last = std::max(last, end_of(load.ramp));
  return last;
}

bool Loads::presses() const {
  return !loads_.pressures.empty() ||
         std::ranges::any_of(loads_.surfaces, [](const SurfaceLoad& load) { return load.pressure != 0.0; });
}

void Loads::add_surface_load(const SurfaceLoad& load, const Bodies& bodies, double time) {
  if (load.traction == Vec3{}) return;
  const double factor = factor_at(load.ramp, time);
  for (const Index triangle : load.triangles) {
    const Triangle& t = at(bodies.triangles(), triangle);
    add_to_corners(t, (0.5 * factor * length(area_vector(bodies.points_rest(), t))) * load.traction, sum_);
  }
}

void Loads::sum_pressures(const Bodies& bodies, double time) {
  pressure_of_triangle_.assign(bodies.triangles().size(), 0.0);
  if (!loads_.pressures.empty()) std::ranges::copy(loads_.pressures, pressure_of_triangle_.begin());
  for (const SurfaceLoad& load : loads_.surfaces) {
    if (load.pressure == 0.0) continue;
    const double pressure = factor_at(load.ramp, time) * load.pressure;
    for (const Index triangle : load.triangles) at(pressure_of_triangle_, triangle) += pressure;
  }
}

/// The pressure of least size on triangles that are not held, if all have one sign; otherwise 0.
double Loads::common_pressure(const Bodies& bodies, const Range& triangles) const {
  double least = 0.0;
  for (Index t = triangles.begin; t < triangles.end; ++t) {
    if (std::ranges::none_of(at(bodies.triangles(), t), [&](Index p) { return at(free_, p) != 0; })) continue;
    const double pressure = at(pressure_of_triangle_, t);
    if (pressure == 0.0 || pressure * least < 0.0) return 0.0;
    if (least == 0.0 || std::abs(pressure) < std::abs(least)) least = pressure;
  }
  return least;
}

void Loads::add_pressures(const Bodies& bodies, std::span<const Vec3> positions, double time) {
  turning_.clear();
  ambient_.clear();
  if (!presses()) return;
  sum_pressures(bodies, time);
  turning_.resize(masses_.size());
  ambient_.resize(bodies.bodies().size());
  for (std::size_t b = 0; b < ambient_.size(); ++b) {
    const Range range = bodies.bodies()[b].triangles;
    ambient_[b] = takes_ambient_[b] != 0 ? common_pressure(bodies, range) : 0.0;
    for (Index triangle = range.begin; triangle < range.end; ++triangle) {
      const double excess = at(pressure_of_triangle_, triangle) - ambient_[b];
      if (excess == 0.0) continue;
      const Triangle& t = at(bodies.triangles(), triangle);
      add_to_corners(t, (-0.5 * excess) * area_vector(positions, t), turning_);
    }
  }
  for (std::size_t p = 0; p < sum_.size(); ++p) sum_[p] += turning_[p];
}

fem::ExternalForces Loads::forces(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& gravity,
                                  double time_end) {
  if (loads_.points.empty() && loads_.surfaces.empty() && loads_.pressures.empty() && loads_.gravity.empty())
    return {.all = loads_.forces, .turning = {}, .ambient = {}};
  sum_.resize(masses_.size());
  if (loads_.forces.empty()) std::ranges::fill(sum_, Vec3{});
  if (!loads_.forces.empty()) std::ranges::copy(loads_.forces, sum_.begin());
  for (const PointLoad& load : loads_.points) {
    const double factor = factor_at(load.ramp, time_end) / static_cast<double>(load.points.size());
    for (const Index point : load.points) at(sum_, point) += factor * load.force;
  }
  for (const SurfaceLoad& load : loads_.surfaces) add_surface_load(load, bodies, time_end);
  add_pressures(bodies, positions, time_end);
  for (std::size_t b = 0; b < loads_.gravity.size(); ++b) {
    if (!loads_.gravity[b]) continue;
    const Range range = bodies.bodies()[b].points;
    for (Index p = range.begin; p < range.end; ++p)
      at(sum_, p) += at(masses_, p) * (*loads_.gravity[b] - gravity);
  }
  return {.all = sum_, .turning = turning_, .ambient = ambient_};
}

}  // namespace palpate
