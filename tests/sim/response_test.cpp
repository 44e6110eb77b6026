// Oracles: Newton's third law for forces and torques; the forces of one contact by hand.
#include "sim/response.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "contact/detector_steps.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

struct Pressed {
  Pressed() {
    bodies.add("lower", test::box_mesh({3, 3, 2}, {-0.3, -0.3, -0.2}, {0.3, 0.3, 0.0}));
    bodies.add("upper", test::ball_mesh(4, {0.02, 0.01, 0.08}, 0.1));
    materials = {Material{.young_modulus = 1e4}, Material{.young_modulus = 3e4}};
    masses.assign(bodies.points_rest().size(), 0.01);
    moves.assign(bodies.points_rest().size(), 1);
  }
  std::vector<fem::Coupling> couplings(const ResponseSettings& settings, std::span<const Vec3> velocities,
                                       double time_step = 0.01) {
    Detector detector(bodies, {}, {}, 1);
    detector.detect(bodies.points_rest());
    contacts = detector.contacts();
    ContactResponse response(bodies, materials, std::vector<std::uint8_t>{0, 0}, settings, masses, moves);
    std::vector<fem::Coupling> result;
    response.compute(parallel::Threads(2), bodies, DetectorSteps::table(detector), bodies.points_rest(),
                     velocities, {.since = time_step, .ahead = time_step}, 0.0, result);
    for (std::size_t c = 0; c < result.size(); ++c) {
      const Vec3 u = fem::relative(result[c], velocities);
      const fem::ContactLaw& law = response.laws()[c];
      result[c].force = fem::contact_force(law, {.coefficient = settings.friction, .time_step = time_step}, u)
                            .whole(law.direction);
    }
    return result;
  }
  Bodies bodies;
  std::vector<Material> materials;
  std::vector<double> masses;
  std::vector<std::uint8_t> moves;
  Contacts contacts;
};

TEST(ContactResponse, ForcesAndTorquesAddUpToZero) {
  Pressed pressed;
  test::Random random(3);
  std::vector<Vec3> velocities(pressed.bodies.points_rest().size());
  for (Vec3& v : velocities) v = random.point(-1, 1);
  ResponseSettings settings;
  settings.friction = 0.6;
  const auto couplings = pressed.couplings(settings, velocities);
  ASSERT_GT(couplings.size(), 5U);
  Vec3 force;
  Vec3 torque;
  double size = 0.0;
  for (const fem::Coupling& c : couplings) {
    const Vec3 f = fem::end_force(c, 0.01, velocities);  // with damping and friction
    size += length(f);
    for (std::size_t i = 0; i < 5; ++i) {
      force += c.coefficients[i] * f;
      torque += c.coefficients[i] * cross(at(pressed.bodies.points_rest(), c.points[i]), f);
    }
  }
  EXPECT_GT(size, 1e-3);
  EXPECT_LE(length(force), 1e-14 * size);
  EXPECT_LE(length(torque), 1e-14 * size);
}

TEST(ContactResponse, StiffnessIsOfTwoSpringsInSeries) {
  Pressed pressed;
  const auto edge = [&](Index b) {
    return mesh_statistics(pressed.bodies, pressed.bodies.points_rest(), b).edge_length.mean;
  };
  const ResponseSettings settings;
  const double lower = 10.0 * 1e4 * edge(0);
  const double upper = 10.0 * 3e4 * edge(1);
  const ContactResponse both(pressed.bodies, pressed.materials, std::vector<std::uint8_t>{0, 0}, settings,
                             pressed.masses, pressed.moves);
  EXPECT_NEAR(both.stiffness(0, 1), lower * upper / (lower + upper), 1e-9 * lower);
  EXPECT_EQ(both.stiffness(0, 1), both.stiffness(1, 0));
  const ContactResponse on_rock(pressed.bodies, pressed.materials, std::vector<std::uint8_t>{1, 0}, settings,
                                pressed.masses, pressed.moves);
  EXPECT_NEAR(on_rock.stiffness(0, 1), upper, 1e-9 * upper);
}

TEST(ContactResponse, PushesAlongTheDirectionAndFrictionOpposesSliding) {
  Pressed pressed;
  ResponseSettings settings;
  settings.stiffness = 100.0;
  settings.damping = 0.0;
  settings.friction = 0.01;
  std::vector<Vec3> velocities(pressed.bodies.points_rest().size());
  const Range ball = pressed.bodies.bodies()[1].points;
  for (Index p = ball.begin; p < ball.end; ++p) at(velocities, p) = {0.2, 0.0, 0.0};
  // In a step of 1 ms the ball slides 0.2 mm: twice the largest slip of the springs at a depth of 10 mm.
  const double h = 1e-3;
  const auto couplings = pressed.couplings(settings, velocities, h);
  std::size_t checked = 0;
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    if (pressed.contacts.body[c] != 0) continue;
    ++checked;
    const Vec3& r = pressed.contacts.direction[c];
    const Vec3 force = fem::end_force(couplings[c], h, velocities);
    const double normal_force = 100.0 * (pressed.contacts.depth[c] - h * 0.2 * r.x);
    EXPECT_NEAR(dot(force, r), normal_force, 1e-12)
        << "far from the rim: all of k d r at the end of the step";
    const Vec3 friction = force - dot(force, r) * r;
    EXPECT_NEAR(length(friction), 0.01 * normal_force, 1e-9 * normal_force) << "Coulomb's force";
    EXPECT_LT(friction.x, 0.0) << "against the motion";
  }
  EXPECT_GT(checked, 3U);
}

TEST(ContactResponse, HasNoForceWhereItWouldPull) {
  Pressed pressed;
  ResponseSettings settings;
  settings.friction = 0.5;
  std::vector<Vec3> velocities(pressed.bodies.points_rest().size());
  const Range ball = pressed.bodies.bodies()[1].points;
  for (Index p = ball.begin; p < ball.end; ++p) at(velocities, p) = {1.0, 0.0, 100.0};
  const auto couplings = pressed.couplings(settings, velocities, 0.01);
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    if (std::abs(pressed.contacts.direction[c].z) < 0.5) continue;
    EXPECT_LT(length(fem::end_force(couplings[c], 0.01, velocities)), 1e-12) << c;
  }
}

/// A spike in a box. Its tip is 1 cm deep at first.
struct SpikeInABox {
  explicit SpikeInABox(const ResponseSettings& settings)
      : masses(bodies.points_rest().size(), 1.0),
        moves(masses.size(), 1),
        response(bodies, std::vector<Material>(2), std::vector<std::uint8_t>{0, 0}, settings, masses, moves),
        detector(bodies, {}, {}, 1) {}
  /// The law of the tip, if it is inside, with the spike at this height.
  const fem::ContactLaw* law(double z, const Vec3& velocity, double since) {
    std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
    std::vector<Vec3> velocities(positions.size());
    const Range spike = bodies.bodies()[1].points;
    for (Index p = spike.begin; p < spike.end; ++p) {
      at(positions, p).z += z;
      at(velocities, p) = velocity;
    }
    detector.detect(positions);
    std::vector<fem::Coupling> couplings;
    response.compute(parallel::Threads(1), bodies, DetectorSteps::table(detector), positions, velocities,
                     {.since = since, .ahead = h}, 0.0, couplings);
    return couplings.empty() ? nullptr : response.laws().data();
  }
  static Bodies box_and_spike() {
    Bodies bodies;
    bodies.add("lower", test::box_mesh({3, 3, 2}, {-0.3, -0.3, -0.2}, {0.3, 0.3, 0.0}));
    bodies.add("spike", {{{0.01, 0.02, -0.01}, {0.06, 0.02, 0.5}, {0.01, 0.07, 0.5}, {-0.04, 0, 0.5}},
                         {{0, 1, 2, 3}}});
    return bodies;
  }
  static constexpr double h = 0.001;
  Bodies bodies = box_and_spike();
  std::vector<double> masses;
  std::vector<std::uint8_t> moves;
  ContactResponse response;
  Detector detector;
};

TEST(ContactResponse, DampsChatterByTheErrorOfTheForceWhichDecays) {
  // The spike enters at 1 m/s, then leaves at 1 m/s, deeper than predicted.
  ResponseSettings settings;
  settings.stiffness = 100.0;
  settings.damping = 0.0;
  SpikeInABox spike(settings);
  constexpr double h = SpikeInABox::h;
  const auto damping = [&](double z, double speed, double since = SpikeInABox::h) {
    const fem::ContactLaw* law = spike.law(z, {0.0, 0.0, speed}, since);
    return law == nullptr ? 0.0 : law->damping;
  };
  EXPECT_EQ(damping(0.0, -1.0), 0.0) << "new";
  EXPECT_EQ(damping(-0.001, -1.0), 0.0) << "continues as before";
  // Force 100 N/m times 0.015 m; predicted: 1.1 N minus 100 N/m times 0.001 m. Divided by 1 m/s.
  const double first = damping(-0.005, 1.0);
  EXPECT_NEAR(first, 1.5 - 1.0, 1e-9);
  EXPECT_NEAR(damping(-0.004, 1.0), 0.99 * first, 1e-9) << "fades";
  ASSERT_EQ(damping(0.02, 1.0), 0.0) << "gone";
  EXPECT_NEAR(damping(0.0, -1.0), 1.0, 1e-9) << "back: nothing of the force was predicted, 1 N by 1 m/s";
  ASSERT_EQ(damping(0.02, 1.0), 0.0);
  for (int i = 0; i < ContactTable::longest_absence; ++i) damping(0.02, 1.0);
  EXPECT_EQ(damping(0.0, -1.0), 0.0) << "forgotten";
  damping(0.0, -1.0);
  EXPECT_NEAR(damping(-0.005, 1e-9), 20.0 * h * 100.0, 1e-9) << "bounded";
  for (int i = 0; i <= ContactTable::longest_absence; ++i) damping(0.02, 1.0);
  damping(0.0, -1.0);
  damping(-0.001, -1.0);
  EXPECT_NEAR(damping(-0.005, 1.0, 0.002), 1.5 - 0.9, 1e-9) << "the step before was twice as long";
}

TEST(ContactResponse, ASpringOfFrictionSlipsByTheLengthOfTheStepBefore) {
  ResponseSettings settings;
  settings.friction = 0.5;
  SpikeInABox spike(settings);
  const auto slip = [&](double since) { return spike.law(0.0, {0.1, 0.0, 0.0}, since)->slip.x; };
  EXPECT_EQ(slip(0.001), 0.0) << "new";
  EXPECT_NEAR(slip(0.001), 1e-4, 1e-12) << "1 ms at 0.1 m/s";
  EXPECT_NEAR(slip(0.004), 5e-4, 1e-12) << "and 4 ms";
}

TEST(ContactResponse, FadesOutOverARim) {
  // One point slides out over the side of a box: the force falls to zero without a jump.
  double last = -1.0;
  double largest_jump = 0.0;
  double first = 0.0;
  const int steps = 400;
  for (int i = 0; i <= steps; ++i) {
    Bodies bodies;
    bodies.add("lower", test::box_mesh({3, 3, 2}, {-0.3, -0.3, -0.2}, {0.3, 0.3, 0.0}));
    const double x = 0.2 + 0.12 * i / steps;
    bodies.add("spike",
               {{{x, 0.01, -0.01}, {x + 0.01, 0, 0.5}, {x, 0.02, 0.5}, {x - 0.01, 0, 0.5}}, {{0, 1, 2, 3}}});
    const std::vector<Material> materials(2);
    const std::vector<double> masses(bodies.points_rest().size(), 1.0);
    const std::vector<std::uint8_t> moves(bodies.points_rest().size(), 1);
    Detector detector(bodies, {}, {}, 1);
    detector.detect(bodies.points_rest());
    ResponseSettings settings;
    settings.stiffness = 100.0;
    ContactResponse response(bodies, materials, std::vector<std::uint8_t>{0, 0}, settings, masses, moves);
    std::vector<fem::Coupling> couplings;
    response.compute(parallel::Threads(1), bodies, DetectorSteps::table(detector), bodies.points_rest(),
                     std::vector<Vec3>(masses.size()), {.since = 0.01, .ahead = 0.01}, 0.0, couplings);
    double force = 0.0;
    for (std::size_t c = 0; c < couplings.size(); ++c) {
      if (couplings[c].points[0] != bodies.bodies()[1].points.begin) continue;
      const fem::ContactLaw& law = response.laws()[c];
      force += fem::contact_force(law, {.coefficient = 0.0, .time_step = 0.01}, {}).whole(law.direction).z;
    }
    if (i == 0) first = force;
    if (i > 0) largest_jump = std::max(largest_jump, std::abs(force - last));
    last = force;
  }
  EXPECT_NEAR(first, 1.0, 1e-9) << "100 N/m times 0.01 m";
  EXPECT_EQ(last, 0.0);
  // Without rim falloff it would jump from 1 to 0. The remaining jump: an edge that begins to cross the side
  // changes the direction.
  EXPECT_LT(largest_jump, 0.04);
}

}  // namespace
}  // namespace palpate
