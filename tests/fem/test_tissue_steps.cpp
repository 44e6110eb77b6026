// Steps of bodies with hyperelastic tissue. Oracles: closed forms of homogeneous stretches, Newton's law in
// its implicit form, momenta; meshes that start inverted.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <memory>

#include "fem/meshes.hpp"
#include "support/meshes.hpp"
#include "support/simd_targets.hpp"

namespace palpate::fem::test {
namespace {

Material tissue_of(double nu, MaterialModel model = MaterialModel::stable_neo_hookean) {
  return {.young_modulus = 2e4, .poisson_ratio = nu, .stiffness_damping = 0.002, .model = model};
}

/// Nominal stress on axis i of diag(s), of the stable neo-Hookean law as its paper writes it.
double neo_hookean_nominal(const Material& m, const std::array<double, 3>& s, std::size_t i) {
  const double shear = m.young_modulus / (2.0 * (1.0 + m.poisson_ratio));
  const double first_lame =
      m.young_modulus * m.poisson_ratio / ((1.0 + m.poisson_ratio) * (1.0 - 2.0 * m.poisson_ratio));
  const double mu = 4.0 / 3.0 * shear;
  const double lambda = first_lame + 5.0 / 6.0 * shear;
  const double alpha = 1.0 + mu / lambda - mu / (4.0 * lambda);
  const double j = s[0] * s[1] * s[2];
  const double sum = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
  return mu * s[i] * (1.0 - 1.0 / (sum + 1.0)) + lambda * (j - alpha) * j / s[i];
}

/// Lateral stretch without lateral stress.
double side_of(const Material& m, double along) {
  return zero_of([&](double t) { return neo_hookean_nominal(m, {along, t, t}, 1); }, 0.1, 3.0);
}

constexpr Vec3 box{1.0, 0.75, 0.375};  // cells of exact size

/// Forces on the points of the far end of the box, N, of a pull of `stress` on the area at rest.
std::vector<Vec3> pull_on_end(const Bodies& bodies, double stress) {
  const auto rest = bodies.points_rest();
  std::vector<Vec3> forces(rest.size());
  for (const Triangle& t : bodies.triangles()) {
    if (!std::ranges::all_of(t, [&](Index p) { return at(rest, p).x == box.x; })) continue;
    const Vec3& corner = at(rest, t[0]);
    const double area = 0.5 * length(cross(at(rest, t[1]) - corner, at(rest, t[2]) - corner));
    for (const Index p : t) at(forces, p).x += stress * area / 3.0;
  }
  return forces;
}

/// A box whose near end is held at its positions in a uniform stretch, so that the stretch is uniform.
struct UniformBox {
  UniformBox(const Material& m, double along, double side) {
    const auto stretched = [&](const Vec3& p) { return Vec3{along * p.x, side * p.y, side * p.z}; };
    expected = mapped(bodies, stretched);
    dynamics = std::make_unique<Dynamics>(bodies, std::vector<Material>(1, m),
                                          select(bodies, [](const Vec3& p) { return p.x == 0.0; }),
                                          std::vector<std::uint8_t>(1, 0), parallel::Threads(1));
    dynamics->set_positions(mapped(bodies, [&](const Vec3& p) { return p.x == 0.0 ? stretched(p) : p; }));
  }
  [[nodiscard]] double error() const { return largest_distance(dynamics->positions(), expected); }
  Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, box, 0.2));
  std::vector<Vec3> expected;
  std::unique_ptr<Dynamics> dynamics;
};

/// Static equilibrium, by steps of huge length without velocity.
void settle_tissue(Dynamics& dynamics, std::span<const Vec3> forces) {
  const std::vector<Vec3> still(dynamics.positions().size());
  for (int n = 0; n < 12; ++n) {
    dynamics.step(100.0, {}, forces, {}, 1e-11, 20000);
    dynamics.set_velocities(still);
    dynamics.set_velocity_changes(still);
  }
}

TEST(MaterialStatics, UniaxialStretchOfABoxIsThatOfTheClosedForm) {
  for (const double nu : {0.0, 0.45}) {
    Material m = tissue_of(nu);
    m.stiffness_damping = 0.0;
    for (const double along : {1.1, 1.6}) {
      const double side = side_of(m, along);
      UniformBox uniform(m, along, side);
      settle_tissue(*uniform.dynamics,
                    pull_on_end(uniform.bodies, neo_hookean_nominal(m, {along, side, side}, 0)));
      EXPECT_LT(uniform.error(), 1e-6) << nu << ", " << along;
    }
  }
}

/// Active fibres shorten a free box until its stress carries their tension.
TEST(FibreStatics, AMuscleShortensAsTheClosedFormSays) {
  Material m = tissue_of(0.45);
  m.stiffness_damping = 0.0;
  m.fibres = Fibres{.direction = {2.0, 0.0, 0.0}, .stiffness = 1e4, .exponent = 1.0, .active_stress = 1e4};
  for (const double activation : {0.3, 1.0}) {
    const double tension = 1e4 * activation;
    const auto stress = [&](double s) {
      return neo_hookean_nominal(m, {s, side_of(m, s), side_of(m, s)}, 0) +
             tension * s / std::sqrt(s * s + 1e-6);
    };
    const double along = zero_of(stress, 0.2, 1.0);
    UniformBox muscle(m, along, side_of(m, along));
    muscle.dynamics->set_activations(std::vector<double>{activation});
    settle_tissue(*muscle.dynamics, std::vector<Vec3>(muscle.expected.size()));
    EXPECT_LT(muscle.error(), 1e-6) << activation;
    EXPECT_LT(along, 0.95);
  }
}

/// A long step with a large deformation: m (v - v_0) = h f(x + h v) at its end, which one linearisation
/// misses.
TEST(MaterialSteps, EndAtTheSolutionOfTheNonlinearProblem) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, box, 0.2));
  Material m = tissue_of(0.45);
  m.stiffness_damping = 0.0;
  const auto held = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
  constexpr double h = 0.05;
  Dynamics dynamics = Scene{m, held, 1}.dynamics(bodies);
  dynamics.set_velocities(mapped(bodies, [](const Vec3& p) { return Vec3{-8.0 * p.x, 0.0, 0.0}; }));
  const std::vector<Vec3> before(dynamics.velocities().begin(), dynamics.velocities().end());
  dynamics.begin_step(h, {0.0, 0.0, -9.81}, {});
  int solves = 0;
  double first = 0.0;
  double last = 0.0;
  do {
    dynamics.solve({}, {.tolerance = 1e-10, .max_iterations = 2000});
    Elements exact(bodies, std::vector<Material>(1, m), std::vector<std::uint8_t>(1, 0));
    exact.update_one_by_one(dynamics.end_positions());
    double error = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (held[i] != 0) continue;
      const Vec3 change = dynamics.point_masses()[i] *
                          (dynamics.mean_velocities()[i] - before[i] - h * Vec3{0.0, 0.0, -9.81});
      error += squared_length(change - h * point_forces(exact)[i]);
      size += squared_length(change);
    }
    last = std::sqrt(error / size);
    if (++solves == 1) first = last;
  } while (solves < 20 && dynamics.relinearise_tissue(1e-8));
  dynamics.end_step();
  EXPECT_GT(first, 0.05);
  EXPECT_LT(last, 1e-6);
  EXPECT_LT(solves, 20);
  std::printf("%d linearisations, errors %.2e to %.2e\n", solves, first, last);
}

/// The tangent of fibres jumps where they begin to be stretched. If their damping had the jump, too, there
/// would be steps without a solution. It is that of the start: m (v - v_0) = h (f(x + h v) - b K(x) v), also
/// where points are held, with the forces that hold them.
TEST(MaterialSteps, DampFibresAsAtTheStart) {
  constexpr double h = 0.01;
  constexpr double damping = 0.02;
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, box, 0.2));
  const auto held = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
  const std::vector<Vec3> start = noisy(bodies, 0.01, 4);
  for (const ElementKind kind : {ElementKind::linear, ElementKind::smoothed}) {
    Material m = tissue_of(0.45);
    m.stiffness_damping = damping;
    m.fibres = Fibres{.direction = {1.0, 0.0, 0.0}, .stiffness = 2e5, .exponent = 1.0};
    m.elements = kind;
    Dynamics dynamics = Scene{m, held, 1}.dynamics(bodies);
    dynamics.set_positions(start);
    dynamics.set_velocities(mapped(bodies, [](const Vec3& p) {
      return Vec3{p.x * std::sin(12.0 * p.y + 9.0 * p.z), 0.0, 0.0};
    }));
    const std::vector<Vec3> before(dynamics.velocities().begin(), dynamics.velocities().end());
    dynamics.find_constrained_elements();
    dynamics.begin_step(h, {}, {});
    int solves = 0;
    do {
      ASSERT_TRUE(dynamics.solve({}, {.tolerance = 1e-10, .max_iterations = 3000}).converged);
    } while (++solves < 20 && dynamics.relinearise_tissue(1e-8));
    ASSERT_LT(solves, 20);
    std::vector<Vec3> holding(start.size());
    dynamics.holding_forces({}, {}, holding);
    dynamics.end_step();
    const auto elements_at = [&](std::span<const Vec3> positions) {
      Elements exact(bodies, std::vector<Material>(1, m), std::vector<std::uint8_t>(1, 0));
      exact.update_one_by_one(positions);
      return exact;
    };
    const std::vector<Vec3> elastic = point_forces(elements_at(dynamics.positions()));
    // The rotation of the body is not damped.
    std::vector<Vec3> strained = rotation_of(dynamics.point_masses(), start, before);
    for (std::size_t i = 0; i < strained.size(); ++i) strained[i] = dynamics.velocities()[i] - strained[i];
    const auto damped = [&](std::span<const Vec3> positions) {
      return unpadded(elements_at(positions).multiply(parallel::Threads(1), padded(strained)));
    };
    const std::vector<Vec3> at_start = damped(start);
    const std::vector<Vec3> at_end = damped(dynamics.positions());
    double error = 0.0;
    double jump = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Vec3 change = dynamics.point_masses()[i] * (dynamics.velocities()[i] - before[i]);
      error += squared_length(change - h * (elastic[i] - damping * at_start[i] + holding[i]));
      jump += squared_length(h * damping * (at_end[i] - at_start[i]));
      size += squared_length(change);
    }
    EXPECT_LT(error, 1e-12 * size);
    EXPECT_GT(jump, 0.01 * size);
  }
}

/// A thin muscle with oblique fibres that contracts. With the tangents of fibres and of tissue apart, or of
/// shape and volume, each of its steps made the most linearisations and did not converge.
TEST(MaterialSteps, OfActiveFibresConverge) {
  const Bodies bodies = single_body(box_mesh({8, 4, 2}, {0.025, 0.01, 0.003}));
  const auto held = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
  struct Kind {
    MaterialModel model;
    double nu;
    ElementKind elements;
  };
  for (const Kind& kind : {Kind{MaterialModel::stable_neo_hookean, 0.45, ElementKind::linear},
                           Kind{MaterialModel::mooney_rivlin, 0.45, ElementKind::linear},
                           Kind{MaterialModel::stable_neo_hookean, 0.4, ElementKind::smoothed},
                           Kind{MaterialModel::stable_neo_hookean, 0.49, ElementKind::smoothed}}) {
    Material m{
        .young_modulus = 9e5, .poisson_ratio = kind.nu, .model = kind.model, .elements = kind.elements};
    m.fibres = Fibres{.direction = {0.5, -0.6, 0.6}, .stiffness = 0.0, .active_stress = 2.7e5};
    Dynamics dynamics = Scene{m, held, 1}.dynamics(bodies);
    for (int n = 1; n <= 15; ++n) {
      dynamics.set_activations(std::vector<double>{std::min(1.0, 0.1 * n)});
      EXPECT_TRUE(dynamics.step(0.01, {}, {}, {}, 1e-4, 1000).converged) << n;
    }
  }
}

/// Two kinds of bodies, and tets of three laws and with fibres in one of them.
struct MixedBodies {
  MixedBodies() {
    bodies.add("soft", irregular_box_mesh({4, 3, 3}, box, 0.2));
    bodies.add("plain", irregular_box_mesh({3, 3, 3}, box, 0.2));
    materials.all = {tissue_of(0.45), tissue_of(0.3, MaterialModel::corotational),
                     tissue_of(0.4, MaterialModel::mooney_rivlin)};
    materials.all[0].fibres =
        Fibres{.direction = {1.0, 1.0, 0.0}, .stiffness = 5e3, .exponent = 1.0, .active_stress = 2e3};
    for (Index t = 0; t < static_cast<Index>(bodies.tets().size()); ++t) {
      const bool plain = bodies.body_of(at(bodies.tets(), t)) == 1 || t % 7 == 1;
      materials.of_tet.push_back(plain ? 1 : (t % 5 == 0 ? 2 : 0));
    }
  }
  [[nodiscard]] Elements elements() const {
    Elements made(bodies, materials, std::vector<std::uint8_t>(2, 0));
    made.set_activations(std::vector<double>{0.5, 0.0, 0.0});
    made.set_factors(std::vector<double>(static_cast<std::size_t>(made.size()), 1e-4));
    made.set_ambient(std::vector<double>{900.0, 0.0});
    return made;
  }
  Bodies bodies;
  Materials materials{std::vector<Material>{}};
};

/// Some tets are inverted, and some are beyond the range of the exponential.
TEST(MaterialTargets, TheKernelEqualsItsTwin) {
  const MixedBodies c;
  const auto positions = noisy(c.bodies, 0.15, 3);
  Elements expected = c.elements();
  expected.update_one_by_one(positions);
  ASSERT_GT(expected.tangent_begin(), 100);
  int inverted = 0;
  palpate::test::for_each_simd_target([&](const char* target) {
    Elements found = c.elements();
    found.update(parallel::Threads(1), positions);
    for (Index e = found.tangent_begin(); e < found.size(); ++e) {
      inverted += found.inverted(e) ? 1 : 0;
      ASSERT_EQ(found.inverted(e), expected.inverted(e)) << target << ", " << e;
      ASSERT_NEAR(found.energy(e), expected.energy(e), 1e-11 * std::abs(expected.energy(e)) + 1e-12)
          << target;
      double size = 0.0;
      for (std::size_t k = 0; k < tangent_values; ++k)
        size = std::max(size, std::abs(static_cast<double>(expected.element_tangent(e)[k])));
      for (std::size_t k = 0; k < tangent_values; ++k)  // they are stored in float
        ASSERT_NEAR(found.element_tangent(e)[k], expected.element_tangent(e)[k], 1.2e-7 * size)
            << target << ", " << e;
    }
    const auto a = found.point_forces();
    const auto b = expected.point_forces();
    for (std::size_t i = 0; i < a.size(); ++i) {
      const Vec3 force{b[i].x, b[i].y, b[i].z};
      ASSERT_LT(length(Vec3{a[i].x, a[i].y, a[i].z} - force), 1e-11 * length(force) + 1e-9) << target;
    }
  });
  EXPECT_GT(inverted, 5);
}

/// Oracle: the forces of a pressure on the triangles of the surface, and the volume that they enclose.
TEST(MaterialTargets, AmbientPressureIsThatOnTheSurface) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, box, 0.2));
  Material m = tissue_of(0.45);
  m.fibres = Fibres{.direction = {1.0, 1.0, 0.0}, .stiffness = 5e3, .exponent = 1.0};
  const Materials materials{std::vector<Material>(1, m)};
  const auto positions = noisy(bodies, 0.02, 3);
  constexpr double pressure = 3e4;
  std::vector<Vec3> expected(positions.size());
  double volume = -box.x * box.y * box.z;
  for (const Triangle& t : bodies.triangles()) {
    const Vec3& corner = at(positions, t[0]);
    const Vec3 area = 0.5 * cross(at(positions, t[1]) - corner, at(positions, t[2]) - corner);
    volume += dot(corner, area) / 3.0;
    for (const Index p : t) at(expected, p) += (-pressure / 3.0) * area;
  }
  const auto expect = [&](bool one_by_one) {
    Elements plain(bodies, materials, std::vector<std::uint8_t>(1, 0));
    ASSERT_EQ(plain.ambient_bodies(1), std::vector<std::uint8_t>(1, 1));
    Elements pressed = plain;
    EXPECT_TRUE(pressed.set_ambient(std::vector<double>(1, pressure)));
    EXPECT_FALSE(pressed.set_ambient(std::vector<double>(1, pressure)));
    double work = 0.0;
    for (Elements* elements : {&plain, &pressed}) {
      if (one_by_one)
        elements->update_one_by_one(positions);
      else
        elements->update(parallel::Threads(1), positions);
      for (Index e = 0; e < elements->size(); ++e) {
        work += (elements == &pressed ? 1.0 : -1.0) * elements->energy(e);
        EXPECT_EQ(elements->energy(e, positions), plain.energy(e, positions));
      }
    }
    EXPECT_NEAR(work, pressure * volume, 1e-9 * pressure * box.x * box.y * box.z);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Vec3 found{pressed.point_forces()[i].x - plain.point_forces()[i].x,
                       pressed.point_forces()[i].y - plain.point_forces()[i].y,
                       pressed.point_forces()[i].z - plain.point_forces()[i].z};
      EXPECT_LT(length(found - expected[i]), 1e-10 * pressure * box.x * box.y) << i;
    }
  };
  expect(true);
  palpate::test::for_each_simd_target([&](const char*) { expect(false); });
}

TEST(MaterialTargets, HaveTheSameBits) {
  const MixedBodies c;
  std::vector<std::vector<Vec3>> ends;
  palpate::test::for_each_simd_target(palpate::test::targets_of_same_bits(), [&](const char*) {
    Dynamics d(c.bodies, c.materials, std::vector<std::uint8_t>(c.bodies.points_rest().size(), 0),
               std::vector<std::uint8_t>(2, 0), parallel::Threads(1));
    d.set_positions(noisy(c.bodies, 0.03, 5));
    for (int n = 0; n < 5; ++n) d.step(0.01, {}, {}, {}, 1e-6, 300);
    ends.emplace_back(d.positions().begin(), d.positions().end());
  });
  for (const auto& end : ends) EXPECT_EQ(end, ends.front());
}

/// Random permutations of all points with a large nu do not recover (docs/materials.md).
TEST(MaterialInversion, NoisyFlatAndInsideOutBodiesComeBack) {
  const Bodies ball = single_body(palpate::test::ball_mesh(4, {0.0, 0.0, 0.0}, 0.15));
  std::mt19937_64 random(3);
  const Matrix3 r = random_rotation(random);
  const std::vector<std::vector<Vec3>> starts{noisy(ball, 0.075, 2),
                                              mapped(ball,
                                                     [&](const Vec3& p) {
                                                       const Vec3 q = r * p;
                                                       return Vec3{q.x, q.y, 0.0};
                                                     }),
                                              mapped(ball, [](const Vec3& p) { return -p; })};
  for (const MaterialModel model : {MaterialModel::stable_neo_hookean, MaterialModel::mooney_rivlin}) {
    for (const double nu : {0.3, 0.45}) {
      for (std::size_t s = 0; s < starts.size(); ++s) {
        Dynamics dynamics = Scene{tissue_of(nu, model), {}, 1}.dynamics(ball);
        dynamics.set_positions(starts[s]);
        int n = 0;
        while (n < 100 && (n < 10 || inverted_tets(ball, dynamics.positions()) > 0)) {
          dynamics.step(0.01, {}, {}, {}, 1e-3, 300);
          ++n;
        }
        EXPECT_EQ(inverted_tets(ball, dynamics.positions()), 0) << "start " << s << ", nu " << nu;
      }
    }
  }
}

/// Angular momentum of all bodies about the origin.
Vec3 angular_momentum(const Dynamics& d) {
  Vec3 sum;
  for (std::size_t i = 0; i < d.positions().size(); ++i)
    sum += d.point_masses()[i] * cross(d.positions()[i], d.velocities()[i]);
  return sum;
}

TEST(MaterialSteps, KeepMomentumAndTheBitsOfEveryThreadCount) {
  const MixedBodies c;
  const Bodies& bodies = c.bodies;
  std::vector<std::vector<Vec3>> ends;
  for (const int threads : {1, 3}) {
    Dynamics d(bodies, c.materials, std::vector<std::uint8_t>(bodies.points_rest().size(), 0),
               std::vector<std::uint8_t>(2, 0), parallel::Threads(threads));
    d.set_positions(noisy(bodies, 0.02, 5));
    d.set_velocities(random_vectors(bodies.points_rest().size(), 0.5, 7));
    Vec3 momentum;
    for (std::size_t i = 0; i < d.velocities().size(); ++i)
      momentum += d.point_masses()[i] * d.velocities()[i];
    const double size = length(angular_momentum(d)) + length(momentum);
    for (int n = 0; n < 20; ++n) d.step(0.01, {}, {}, {}, 1e-8, 500);
    Vec3 after;
    for (std::size_t i = 0; i < d.velocities().size(); ++i) after += d.point_masses()[i] * d.velocities()[i];
    EXPECT_LT(length(after - momentum), 1e-6 * size);
    ends.emplace_back(d.positions().begin(), d.positions().end());
  }
  EXPECT_EQ(ends[0], ends[1]);
}

/// Nothing moves, so relative errors have no reference.
TEST(MaterialSteps, AtRestWithoutLoadsTheyConverge) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 3}, box, 0.2));
  for (const ElementKind elements : {ElementKind::linear, ElementKind::smoothed}) {
    Material m = tissue_of(0.45);
    m.elements = elements;
    Dynamics dynamics = Scene{m, {}, 1}.dynamics(bodies);
    for (int n = 0; n < 3; ++n) EXPECT_TRUE(dynamics.step(0.01, {}, {}, {}, 1e-4, 300).converged);
    EXPECT_TRUE(std::ranges::equal(dynamics.positions(), bodies.points_rest()));
  }
}

/// A restored state continues with the same bits.
TEST(MaterialSteps, GoOnFromASavedState) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, box, 0.2));
  const auto held = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
  Dynamics whole = Scene{tissue_of(0.45), held, 1}.dynamics(bodies);
  Dynamics resumed = Scene{tissue_of(0.45), held, 1}.dynamics(bodies);
  for (int n = 0; n < 10; ++n) {
    if (n == 5) resumed.set_state(whole.state());
    whole.step(0.02, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 300);
    if (n >= 5) resumed.step(0.02, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 300);
  }
  EXPECT_TRUE(std::ranges::equal(whole.positions(), resumed.positions()));
}

}  // namespace
}  // namespace palpate::fem::test
