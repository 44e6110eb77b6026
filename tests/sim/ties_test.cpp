// Points of one body tied to tets of another. Oracles: Newton, and the force of a spring.
#include "sim/ties.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/rotation.hpp"
#include "geometry/vector.hpp"
#include "scene/near.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

/// A block below another, 2 mm apart; the upper one's lowest points are tied to the tets below.
Model tied_blocks(double young_modulus, std::optional<double> stiffness) {
  Model model;
  model.bodies.add("lower", test::box_mesh({2, 2, 1}, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.0}));
  model.bodies.add("upper", test::box_mesh({2, 2, 1}, {-0.1, -0.1, 0.002}, {0.1, 0.1, 0.102}));
  const Material material{.young_modulus = young_modulus, .poisson_ratio = 0.3, .mass_damping = 0.0};
  model.materials = {material, material};
  const Range points = model.bodies.bodies()[1].points;
  for (Index p = points.begin; p < points.end; ++p) {
    const Vec3& place = at(model.bodies.points_rest(), p);
    if (place.z > 0.01) continue;
    // A tet below with the point above its top face: any that has the nearest top point as a corner.
    Index tet = -1;
    for (Index t = 0; t < model.bodies.bodies()[0].tets.end && tet < 0; ++t) {
      for (const Index corner : at(model.bodies.tets(), t)) {
        const Vec3 offset = place - at(model.bodies.points_rest(), corner);
        if (std::hypot(offset.x, offset.y) < 1e-9 && offset.z < 0.01) tet = t;
      }
    }
    model.ties.push_back({p, tet, stiffness});
  }
  return model;
}

TEST(Ties, CarryAWeightLikeSprings) {
  constexpr double k = 2000.0;
  Model model = tied_blocks(1e9, k);
  model.obstacles = {1, 0};
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  for (Index p = 0; p < model.bodies.bodies()[0].points.end; ++p) at(model.fixed_points, p) = 1;
  const auto ties = static_cast<double>(model.ties.size());
  ASSERT_EQ(ties, 9.0);
  SimulationSettings settings;
  settings.gravity = {0.0, 0.0, 9.81};  // away from the other block: no contact helps
  Simulation simulation(std::move(model), settings, 1);
  for (int i = 0; i < 400; ++i) simulation.step();
  const Vec3 rise = test::mean_of_body(simulation.bodies(), 1, simulation.positions()) -
                    test::mean_of_body(simulation.bodies(), 1, simulation.bodies().points_rest());
  const double expected = at(simulation.masses(), 1) * 9.81 / (ties * k);
  EXPECT_NEAR(rise.z, expected, 0.01 * expected);
  EXPECT_LT(std::hypot(rise.x, rise.y), 1e-3 * expected);
  const double weight = at(simulation.masses(), 1) * 9.81;
  const Wrench upper = simulation.tie_wrench(1, {0.3, 0.0, 0.0});
  const Wrench lower = simulation.tie_wrench(0, {0.3, 0.0, 0.0});
  EXPECT_NEAR(upper.force.z, -weight, 1e-4 * weight);
  EXPECT_NEAR(upper.torque.y, -0.3 * weight, 1e-3 * weight) << "the arm is -0.3 m along x";
  EXPECT_LT(length(upper.force + lower.force), 1e-12 * weight);
  EXPECT_LT(length(upper.torque + lower.torque), 1e-9 * weight);
}

TEST(Ties, PullBothBodiesAlike) {
  Model model = tied_blocks(1e5, std::nullopt);
  model.velocities.assign(model.bodies.points_rest().size(), {});
  const Range points = model.bodies.bodies()[1].points;
  for (Index p = points.begin; p < points.end; ++p) at(model.velocities, p) = {0.1, 0.0, 0.3};
  SimulationSettings settings;
  settings.gravity = {};
  settings.solver.tolerance = 1e-10;
  Simulation simulation(std::move(model), settings, 1);
  // Masses of the points differ: the momentum is the sum over them, not that of the mean velocity.
  const Bodies& bodies = simulation.bodies();
  std::vector<double> masses(bodies.points_rest().size(), 0.0);
  for (const Tet& t : bodies.tets()) {
    const auto corner = [&](std::size_t i) { return at(bodies.points_rest(), t[i]); };
    const double six = dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0));
    for (const Index p : t) at(masses, p) += 1000.0 * six / 24.0;
  }
  const auto total = [&](Index body) {
    Vec3 sum;
    const Range range = at(bodies.bodies(), body).points;
    for (Index p = range.begin; p < range.end; ++p) sum += at(masses, p) * at(simulation.velocities(), p);
    return sum;
  };
  const Vec3 before = total(0) + total(1);
  for (int i = 0; i < 20; ++i) simulation.step();
  EXPECT_GT(length(total(0)), 0.2 * length(before)) << "the lower block is taken along";
  EXPECT_LT(length(total(0) + total(1) - before), 1e-7 * length(before));
}

TEST(Ties, HaveNoForceAtTheStartAndNoTorqueEver) {
  const Model model = tied_blocks(1e5, std::nullopt);
  const auto count = model.bodies.points_rest().size();
  const std::vector<double> masses(count, 0.01);
  const std::vector<std::uint8_t> moves(count, 1);
  const ContactResponse response(model.bodies, model.materials, std::vector<std::uint8_t>{0, 0}, {}, masses,
                                 moves);
  std::vector<Vec3> positions(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
  const Ties ties(held_ties(model.ties, model.bodies, positions), model.bodies, masses, moves, response);
  std::vector<fem::Coupling> couplings;
  ties.append(positions, couplings);
  ASSERT_EQ(couplings.size(), 9U);
  for (const fem::Coupling& c : couplings) EXPECT_LT(length(c.force), 1e-9 * c.stiffness.xx);
  test::Random random(5);
  for (Vec3& p : positions) p += random.point(-0.03, 0.03);
  couplings.clear();
  ties.append(positions, couplings);
  for (const fem::Coupling& c : couplings) {
    Vec3 force;
    Vec3 torque;
    for (std::size_t i = 0; i < 5; ++i) {
      force += c.coefficients[i] * c.force;
      torque += cross(at(positions, c.points[i]), c.coefficients[i] * c.force);
    }
    EXPECT_GT(length(c.force), 1.0);
    EXPECT_LT(length(force), 1e-12 * length(c.force));
    EXPECT_LT(length(torque), 1e-12 * length(c.force));
    EXPECT_EQ(c.stiffness.xx, response.stiffness(0, 1));
  }
}

/// Two equal bars in a line whose ends overlap; both turned, so that no face is along an axis. The second one
/// is `aside` and turned by `roll` about the line. Points at its end are tied to the first, but for those
/// above `most_height`.
Model overlapping_bars(double young_modulus, double overlap, double aside, double roll, double most_height) {
  Model model;
  constexpr double width = 0.02;
  const Vec3 middle{0.0, 0.5 * width, 0.5 * width};
  std::vector<Vec3> places;  // of all points, in their own bar
  for (const bool second : {false, true}) {
    TetMesh bar = test::box_mesh({8, 4, 4}, {0.0, 0.0, 0.0}, {2.0 * width, width, width});
    places.insert(places.end(), bar.points.begin(), bar.points.end());
    for (Vec3& p : bar.points) {
      if (second) {
        p = rotated(rotation_by({roll, 0.0, 0.0}), p - middle) + middle +
            Vec3{2.0 * width - overlap, aside, 0.5 * aside};
      }
      p = rotated(rotation_by({0.5, -0.8, 0.3}), p);
    }
    model.bodies.add(second ? "second" : "first", bar);
  }
  const Material material{.young_modulus = young_modulus, .poisson_ratio = 0.3, .mass_damping = 0.0};
  model.materials = {material, material};
  const Range points = model.bodies.bodies()[1].points;
  const std::span<const Vec3> x = model.bodies.points_rest();
  for (Index p = points.begin; p < points.end; ++p) {
    if (at(places, p).x == 0.0 && at(places, p).z <= most_height)
      model.ties.push_back({p, nearest_tet(model.bodies, x, 0, at(x, p)), {}});
  }
  return model;
}

TEST(Ties, OfBodiesThatOverlapDoNotTurnThem) {
  for (const double aside : {0.0, 0.006}) {
    SimulationSettings settings;
    settings.time_step = 0.005;
    settings.gravity = {};
    Simulation simulation(overlapping_bars(1e8, 0.0002, aside, 0.0, 1.0), settings, 1);
    for (int i = 0; i < 20; ++i) simulation.step();
    EXPECT_LT(simulation.metrics().largest_speed, 1e-9) << aside << " m aside";
  }
}

/// Only where ties hold two bodies together do they not touch. Oracle: detection without ties.
void expect_touch_where_not_tied(const Model& model) {
  const Bodies& bodies = model.bodies;
  std::set<std::pair<Index, Index>> tied;
  for (const Tie& tie : model.ties) tied.insert({tie.point, bodies.body_of(at(bodies.tets(), tie.tet))});
  const auto is_held = [&](const auto& points, Index other) {
    return std::ranges::any_of(points, [&](Index p) { return tied.contains({p, other}); });
  };
  const auto is_held_edge = [&](const EdgeContacts& edges, std::size_t c) {
    const Edge& ends = at(bodies.edges(), edges.edge[c]);
    return is_held(ends, edges.body[c]) || std::ranges::any_of(edges.triangles[c], [&](Index t) {
             return is_held(at(bodies.triangles(), t), bodies.body_of(ends));
           });
  };
  SimulationSettings settings;
  settings.gravity = {};
  Detector all(bodies, settings.detection, {}, 1);
  all.detect(bodies.points_rest());
  std::set<std::pair<Index, Index>> expected;
  const Contacts& contacts = all.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Tet& tet = at(bodies.tets(), contacts.tet[c]);
    const Index own = at(bodies.body_of_point(), contacts.point[c]);
    if (!is_held(std::array{contacts.point[c]}, contacts.body[c]) && !is_held(tet, own))
      expected.insert({contacts.point[c], contacts.tet[c]});
  }
  EXPECT_GT(expected.size(), 0U);
  EXPECT_LT(expected.size() + 5, contacts.size());
  for (const Structure structure :
       {Structure::compact, Structure::uniform, Structure::hash, Structure::cuckoo, Structure::brute}) {
    settings.detection.structure = structure;
    const Simulation simulation(model, settings, 1);
    const Contacts& found = simulation.detector().contacts();
    std::set<std::pair<Index, Index>> pairs;
    for (std::size_t c = 0; c < found.size(); ++c) pairs.insert({found.point[c], found.tet[c]});
    EXPECT_EQ(pairs, expected);
    const EdgeContacts& edges = simulation.detector().edge_contacts();
    std::set<std::pair<Index, Index>> of_edges;
    for (std::size_t c = 0; c < edges.size(); ++c) {
      of_edges.insert({edges.edge[c], edges.body[c]});
      EXPECT_FALSE(is_held_edge(edges, c));
      EXPECT_LT(edges.parameters[c][0], edges.parameters[c][1]);
    }
    const EdgeContacts& without = all.edge_contacts();
    for (std::size_t c = 0; c < without.size(); ++c)
      EXPECT_TRUE(is_held_edge(without, c) || of_edges.contains({without.edge[c], without.body[c]}));
  }
}

TEST(Ties, HoldOnlyWhatIsTied) {
  for (const double roll : {0.2, 0.4, 0.7, 1.1, 1.3}) {
    SCOPED_TRACE(std::to_string(roll));
    expect_touch_where_not_tied(overlapping_bars(1e5, 0.004, 0.004, roll, 0.006));
  }
}

/// Parts that no tie holds push each other out: the bars bend apart there. So do parts with weak ties.
TEST(Ties, LetOtherPartsTouch) {
  for (const bool weak : {false, true}) {
    Model model = overlapping_bars(1e5, 0.003, 0.0, 0.0, weak ? 1.0 : 0.001);
    for (Tie& tie : model.ties)
      if (weak) tie.stiffness = 1.0;
    SimulationSettings settings;
    settings.gravity = {};
    Simulation simulation(std::move(model), settings, 1);
    const double before = simulation.metrics().deepest;
    for (int i = 0; i < 200; ++i) simulation.step();
    EXPECT_GT(before, 0.0025);
    EXPECT_LT(simulation.metrics().deepest, 0.1 * before);
  }
}

TEST(Ties, RefusesWhatCannotBeTied) {
  const auto message = [](Tie tie) -> std::string {
    Model model = tied_blocks(1e5, std::nullopt);
    model.ties = {tie};
    try {
      Simulation(std::move(model), {}, 1);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({-1, 0, {}}), "ties: [0].point: found -1, expected an index below 36");
  EXPECT_EQ(message({20, 999, {}}), "ties: [0].tet: found 999, expected an index below 48");
  EXPECT_EQ(message({0, 0, {}}),
            "ties: [0]: found a tet of the point's own body, expected a tet of another body");
  EXPECT_EQ(message({20, 0, 0.0}), "ties: [0].stiffness: found 0, expected a finite number > 0");
}

}  // namespace
}  // namespace palpate
