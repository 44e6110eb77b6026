// Viscosity. Oracles: the convolution with the Prony series, written out for a stretch that grows and is
// held; creep of the standard linear solid; energy, objectivity, torque and differences of the energy.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include <palpate/error.hpp>

#include "fem/material_check.hpp"
#include "fem/meshes.hpp"
#include "fem/stress.hpp"
#include "fem/tissue.hpp"

namespace palpate::fem::test {
namespace {

constexpr Vec3 bar_size{1.0, 0.75, 0.375};
const Viscosity three_terms{.fractions = {0.3, 0.2, 0.1}, .times = {0.02, 0.3, 5.0}};
/// A law, and the elements that it is evaluated in.
struct Kind {
  constexpr Kind(MaterialModel law, ElementKind kind = ElementKind::linear) : model(law), elements(kind) {}
  MaterialModel model;
  ElementKind elements;
};
constexpr std::array kinds{Kind(MaterialModel::corotational), Kind(MaterialModel::stable_neo_hookean),
                           Kind(MaterialModel::mooney_rivlin),
                           Kind(MaterialModel::corotational, ElementKind::smoothed),
                           Kind(MaterialModel::stable_neo_hookean, ElementKind::smoothed)};

Material tissue(const Kind& kind, const Viscosity& viscosity = three_terms) {
  return {.young_modulus = 2e4,
          .poisson_ratio = 0.3,
          .model = kind.model,
          .elements = kind.elements,
          .viscosity = viscosity};
}

Material without_viscosity(Material m) {
  m.viscosity = {};
  return m;
}

/// Viscous stress at a later time for an elastic stress that grows linearly from 0 to 1 in `rise` and then
/// stays.
double relaxed(const Viscosity& v, double rise, double time) {
  const double rest = 1.0 - std::accumulate(v.fractions.begin(), v.fractions.end(), 0.0);
  double sum = 1.0;
  for (std::size_t i = 0; i < v.times.size(); ++i) {
    const double tau = v.times[i];
    sum += v.fractions[i] / rest * tau / rise * (std::exp(-(time - rise) / tau) - std::exp(-time / tau));
  }
  return sum;
}

/// Force along x that holds one end of a bar whose both ends are held, N.
double end_force(const Dynamics& dynamics, const Bodies& bodies) {
  std::vector<Vec3> forces(dynamics.positions().size());
  dynamics.holding_forces({}, {}, forces);
  double sum = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (bodies.points_rest()[i].x == bar_size.x) sum += forces[i].x;
  }
  return sum;
}

/// Negligible gravity, m/s^2: a reference for tolerances if all other forces are rounding errors.
constexpr Vec3 hardly_any{0.0, 1e-6, 0.0};

/// A bar of uniform stretch with free sides: all stress relaxes equally, so nothing moves.
class HeldBar {
 public:
  explicit HeldBar(const Material& m)
      : bodies_(single_body(irregular_box_mesh({4, 3, 3}, bar_size, 0.2))),
        material_(m),
        dynamics_(Scene{m, select(bodies_, [](const Vec3& p) { return p.x == 0.0 || p.x == bar_size.x; }), 1}
                      .dynamics(bodies_)) {
    Dynamics elastic =
        Scene{without_viscosity(m),
              select(bodies_, [](const Vec3& p) { return p.x == 0.0 || p.x == bar_size.x; }), 1}
            .dynamics(bodies_);
    elastic.set_positions(mapped(bodies_, [](const Vec3& p) { return Vec3{1.2 * p.x, p.y, p.z}; }));
    settle(elastic, {}, 12);
    elastic.find_constrained_elements();
    elastic.begin_step(1.0, {}, {});
    elastic.solve({}, {.tolerance = 1e-12, .max_iterations = 20000});
    elastic_force_ = end_force(elastic, bodies_);
    dynamics_.set_positions(elastic.positions());
    dynamics_.find_constrained_elements();
  }
  /// Force at the end of the next step, over that of elastic tissue.
  double step(double h) {
    dynamics_.begin_step(h, hardly_any, {});
    int solves = 0;
    do {
      dynamics_.solve({}, {.tolerance = 1e-12, .max_iterations = 20000});
      EXPECT_LT(++solves, 40);
    } while (solves < 40 && dynamics_.relinearise_tissue(1e-3));
    most_solves_ = std::max(most_solves_, solves);
    const double force = end_force(dynamics_, bodies_);
    dynamics_.end_step();
    return force / elastic_force_;
  }
  [[nodiscard]] const Bodies& bodies() const { return bodies_; }
  [[nodiscard]] const Dynamics& dynamics() const { return dynamics_; }
  [[nodiscard]] int most_solves() const { return most_solves_; }
  [[nodiscard]] double elastic_force() const { return elastic_force_; }

 private:
  Bodies bodies_;
  Material material_;
  Dynamics dynamics_;
  double elastic_force_ = 0.0;
  int most_solves_ = 0;
};

TEST(Prony, AStretchedBarRelaxesAsTheSeriesSaysWithStepsOfAnyLength) {
  for (const Kind& kind : kinds) {
    for (const double h : {0.002, 0.1, 20.0}) {
      HeldBar bar(tissue(kind));
      ASSERT_GT(bar.elastic_force(), 100.0);
      for (int n = 1; n <= 40; ++n)
        ASSERT_NEAR(bar.step(h), relaxed(three_terms, h, n * h), 1e-7) << h << ", step " << n;
      std::printf("%d solves\n", bar.most_solves());
    }
  }
}

TEST(Prony, StepsMayChangeTheirLength) {
  HeldBar bar(tissue(MaterialModel::corotational));
  double time = 0.0;
  for (const double h : {0.01, 0.3, 0.004, 2.0, 0.05}) {
    time += h;
    ASSERT_NEAR(bar.step(h), relaxed(three_terms, 0.01, time), 1e-7);
  }
}

/// Stress of tets as it is reported, against the force that holds the bar.
TEST(Prony, TheStressFieldRelaxesWithTheForce) {
  for (const Kind& kind : kinds) {
    HeldBar bar(tissue(kind));
    for (int n = 0; n < 10; ++n) bar.step(0.05);
    const Dynamics& d = bar.dynamics();
    const TissueState state = tissue_of_tets(parallel::Threads(1), bar.bodies(), d.elements(), d.positions());
    // Virtual work of a stretch along x, exact since the elements can represent it.
    double work = 0.0;
    for (Index e = 0; e < d.elements().size(); ++e) {
      const auto tet = static_cast<std::size_t>(d.elements().tet_of_element()[static_cast<std::size_t>(e)]);
      work += d.elements().volumes_rest()[static_cast<std::size_t>(e)] * state.volume_ratio[tet] *
              state.stress[tet].xx;
    }
    const double length = 1.2;
    EXPECT_NEAR(work / length / bar.elastic_force(), relaxed(three_terms, 0.05, 0.5), 1e-7);
    EXPECT_GT(state.stress[0].xx, 0.0);
  }
}

/// Strain of a bar without mass under a load that is there from the start, at t = 0.5, against the standard
/// linear solid.
double creep_error(double h) {
  constexpr double g = 0.6;
  constexpr double tau = 0.2;
  constexpr double load = 20.0;  // N/m^2: a strain of 1e-3
  const Bodies bodies = single_body(irregular_box_mesh({4, 2, 2}, {1.0, 0.5, 0.5}, 0.2));
  Material m = tissue(MaterialModel::corotational, {.fractions = {g}, .times = {tau}});
  m.density = 1e-6;
  m.poisson_ratio = 0.0;
  Dynamics dynamics = Scene{m, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), 1}.dynamics(bodies);
  std::vector<Vec3> forces(bodies.points_rest().size());
  for (const Triangle& t : bodies.triangles()) {
    const auto rest = [&](std::size_t k) { return at(bodies.points_rest(), t[k]); };
    if (rest(0).x != 1.0 || rest(1).x != 1.0 || rest(2).x != 1.0) continue;
    const double area = 0.5 * length(cross(rest(1) - rest(0), rest(2) - rest(0)));
    for (const Index p : t) at(forces, p).x += load * area / 3.0;
  }
  double worst = 0.0;
  const int steps = static_cast<int>(std::lround(1.0 / h));
  for (int n = 1; n <= steps; ++n) {
    dynamics.step(h, {}, forces, {}, 1e-12, 20000);
    const double t = n * h;
    const double expected = load / m.young_modulus * (1.0 - g * std::exp(-t * (1.0 - g) / tau));
    double found = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i)
      found = std::max(found, dynamics.positions()[i].x - bodies.points_rest()[i].x);
    if (t > 0.1) worst = std::max(worst, std::abs(found / expected - 1.0));
  }
  return worst;
}

TEST(Prony, CreepUnderALoadIsThatOfTheStandardLinearSolid) {
  const double coarse = creep_error(0.02);
  const double fine = creep_error(0.01);
  std::printf("creep: errors %.4f, %.4f\n", coarse, fine);
  EXPECT_LT(fine, 0.01);
  EXPECT_NEAR(coarse / fine, 2.0, 0.2);  // the load rises within the first step: first order
}

/// Elements with a history that is independent of their deformation.
Elements remembering(const Bodies& bodies, const Material& m, unsigned seed) {
  Elements elements(bodies, std::vector<Material>(1, m), std::vector<std::uint8_t>(1, 0));
  const parallel::Threads one(1);
  elements.set_time_step(0.05);
  elements.relax(one, noisy(bodies, 0.03, seed));
  elements.relax(one, noisy(bodies, 0.03, seed + 1));
  elements.find_history(one);
  return elements;
}

TEST(ViscousElement, ForcesTurnWithTheBodyAndHaveNoTorque) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 2}, bar_size, 0.2));
  std::mt19937_64 random(4);
  const Matrix3 rotation = random_rotation(random);
  for (const Kind& kind : kinds) {
    Elements elements = remembering(bodies, tissue(kind), 10);
    const auto positions = noisy(bodies, 0.03, 20);
    std::vector<Vec3> turned(positions.size());
    std::ranges::transform(positions, turned.begin(), [&](const Vec3& p) { return rotation * p; });
    elements.update(parallel::Threads(1), positions);
    const auto forces = point_forces(elements);
    elements.update(parallel::Threads(1), turned);
    const auto turned_forces = point_forces(elements);
    Vec3 torque;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      EXPECT_LT(length(rotation * forces[i] - turned_forces[i]), 1e-10 * largest(forces));
      torque += cross(positions[i], forces[i]);
    }
    EXPECT_LT(length(torque), 1e-11 * largest(forces));
    EXPECT_LT(length(total(forces)), 1e-11 * largest(forces));
    // Without the history forces differ, so the test is not void.
    Elements fresh(bodies, std::vector<Material>(1, tissue(kind)), std::vector<std::uint8_t>(1, 0));
    fresh.set_time_step(0.05);
    fresh.update(parallel::Threads(1), positions);
    EXPECT_GT(largest_distance(forces, point_forces(fresh)), 0.05 * largest(forces));
  }
}

TEST(ViscousElement, ForcesAreTheDerivativeOfTheEnergyOfTheStep) {
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, bar_size, 0.2));
  const auto direction = random_vectors(bodies.points_rest().size(), 1.0, 7);
  for (const Kind& kind : kinds) {
    Elements elements = remembering(bodies, tissue(kind), 30);
    const auto positions = noisy(bodies, 0.03, 40);
    const auto energy_at = [&](double s) {
      auto moved = positions;
      for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += s * direction[i];
      elements.update_one_by_one(moved);
      double sum = 0.0;
      for (Index e = 0; e < elements.size(); ++e) sum += elements.energy(e);
      return sum;
    };
    constexpr double d = 1e-4;
    const double slope =
        (8.0 * (energy_at(d) - energy_at(-d)) - (energy_at(2.0 * d) - energy_at(-2.0 * d))) / (12.0 * d);
    elements.update_one_by_one(positions);
    const auto forces = point_forces(elements);
    double work = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i) work += dot(forces[i], direction[i]);
    EXPECT_NEAR(slope / -work, 1.0, 1e-7);
  }
}

/// A bar that is let go: total energy after each step, J.
std::vector<double> energies_of(const Material& m, const Vec3& spin) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 2}, {0.1, 0.06, 0.04}, 0.2));
  Dynamics dynamics = Scene{m, {}, 1}.dynamics(bodies);
  dynamics.set_positions(mapped(bodies, [](const Vec3& p) {
    return Vec3{1.2 * p.x + 0.1 * p.y, 0.9 * p.y, p.z};
  }));
  dynamics.set_velocities(mapped(bodies, [&](const Vec3& p) {
    return cross(spin, p - Vec3{0.05, 0.03, 0.02});
  }));
  std::vector<double> energies;
  for (int n = 0; n < 150; ++n) {
    dynamics.step(0.002, {}, {}, {}, 1e-9, 2000);
    energies.push_back(dynamics.kinetic_energy() + dynamics.elastic_energy());
  }
  return energies;
}

/// Largest growth in a step, relative.
double largest_growth(const std::vector<double>& energies) {
  double most = -1.0;
  for (std::size_t n = 1; n < energies.size(); ++n)
    most = std::max(most, (energies[n] - energies[n - 1]) / energies.front());
  return most;
}

/// A step of a spinning bar in its frame may add about 2e-6 of the first energy.
TEST(Prony, TheEnergyOfAFreeVibrationNeverGrows) {
  const Viscosity viscosity{.fractions = {0.2, 0.2}, .times = {0.005, 0.1}};
  for (const Kind& kind : kinds) {
    const auto still = energies_of(tissue(kind, viscosity), {});
    const auto spinning = energies_of(tissue(kind, viscosity), {0.0, 3.0, 5.0});
    std::printf("growth: still %.1e, spinning %.1e\n", largest_growth(still), largest_growth(spinning));
    EXPECT_LE(largest_growth(still), 1e-12);
    EXPECT_LE(largest_growth(spinning), 4e-6);
    EXPECT_LT(still.back(), 1e-3 * still.front());
  }
}

/// The tangent ignores the history: Newton's method converges linearly, and slower for larger strain.
TEST(Prony, StepsThatStretchFarConverge) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, bar_size, 0.2));
  for (const Kind& kind : std::span(kinds).subspan(1)) {
    const auto ends = select(bodies, [](const Vec3& p) { return p.x == bar_size.x; });
    Dynamics dynamics = Scene{tissue(kind, {.fractions = {0.8}, .times = {0.3}}),
                              select(bodies, [](const Vec3& p) { return p.x == 0.0; }), 1}
                            .dynamics(bodies);
    std::vector<Vec3> forces(bodies.points_rest().size());
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i].x = ends[i] != 0 ? 175.0 : 0.0;
    double stretch = 0.0;
    for (int n = 0; n < 30; ++n) {
      dynamics.begin_step(0.05, {}, {.all = forces, .turning = {}, .ambient = {}});
      int solves = 0;
      do {
        dynamics.solve({}, {.tolerance = 1e-8, .max_iterations = 2000});
      } while (++solves < 30 && dynamics.relinearise_tissue(1e-6));
      EXPECT_LT(solves, 10);
      dynamics.end_step();
      for (const Vec3& p : dynamics.positions()) stretch = std::max(stretch, p.x / bar_size.x);
    }
    EXPECT_GT(stretch, 1.4);
  }
}

void expect_prompt_tension(const Bodies& bodies, Material m) {
  m.fibres = Fibres{.direction = {1.0, 0.0, 0.0}, .stiffness = 1e3, .active_stress = 5e3};
  for (const double h : {0.001, 0.1, 10.0}) {
    Elements elements(bodies, std::vector<Material>(1, m), std::vector<std::uint8_t>(1, 0));
    elements.set_activations(std::vector<double>{1.0});
    elements.set_time_step(h);
    elements.update(parallel::Threads(1), bodies.points_rest());
    const auto found = point_forces(elements);
    Elements plain(bodies, std::vector<Material>(1, without_viscosity(m)), std::vector<std::uint8_t>(1, 0));
    plain.set_activations(std::vector<double>{1.0});
    plain.update(parallel::Threads(1), bodies.points_rest());
    EXPECT_LT(largest_distance(found, point_forces(plain)), 1e-12 * largest(found)) << h;
    elements.relax(parallel::Threads(1), bodies.points_rest());
    EXPECT_FALSE(elements.viscous_stresses().empty());
    for (const SymmetricMatrix3& stress : elements.viscous_stresses()) EXPECT_LT(norm(stress), 1e-8);
  }
}

/// The tension of muscles at a fixed length acts at once and does not relax.
TEST(Prony, ActivationOfFibresIsNotDelayed) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 2, 2}, bar_size, 0.2));
  for (const ElementKind elements : {ElementKind::linear, ElementKind::smoothed})
    expect_prompt_tension(bodies, tissue({MaterialModel::stable_neo_hookean, elements}));
}

TEST(Prony, ABodyThatStartsInsideOutComesBack) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 3}, {0.1, 0.1, 0.1}, 0.2));
  for (const Kind& kind : kinds) {
    Dynamics dynamics = Scene{tissue(kind), {}, 1}.dynamics(bodies);
    dynamics.set_positions(noisy(bodies, 0.03, 5));
    ASSERT_GT(dynamics.inverted_elements(), 10);
    for (int n = 0; n < 100; ++n) dynamics.step(0.01, {}, {}, {}, 1e-4, 500);
    EXPECT_EQ(dynamics.inverted_elements(), 0);
  }
}

TEST(Prony, TheThreadsDoNotChangeTheBits) {
  const Bodies bodies = single_body(irregular_box_mesh({8, 6, 6}, bar_size, 0.2));
  for (const Kind& kind : kinds) {
    std::vector<DynamicsState> states;
    for (const int threads : {1, 3}) {
      Dynamics dynamics = Scene{tissue(kind), {}, threads}.dynamics(bodies);
      dynamics.set_positions(noisy(bodies, 0.02, 6));
      for (int n = 0; n < 5; ++n) dynamics.step(0.01, {}, {}, {}, 1e-6, 500);
      states.push_back(dynamics.state());
    }
    EXPECT_EQ(states[0].positions, states[1].positions);
    EXPECT_EQ(states[0].viscous_stresses, states[1].viscous_stresses);
    EXPECT_GT(norm(states[0].viscous_stresses[1]), 0.0);
  }
}

TEST(Prony, AStateIsTakenWhereItsLengthAndNumbersAreRight) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 2, 2}, bar_size, 0.2));
  Dynamics dynamics = Scene{tissue(MaterialModel::corotational), {}, 1}.dynamics(bodies);
  dynamics.set_positions(noisy(bodies, 0.02, 6));
  const auto step = [&] { dynamics.step(0.01, {}, {}, {}, 1e-8, 500); };
  step();
  const DynamicsState saved = dynamics.state();
  step();
  const DynamicsState expected = dynamics.state();
  dynamics.set_state(saved);
  step();
  EXPECT_EQ(dynamics.state().viscous_stresses, expected.viscous_stresses);
  EXPECT_EQ(dynamics.state().positions, expected.positions);
  DynamicsState bad = saved;
  bad.viscous_stresses.pop_back();
  EXPECT_THROW(dynamics.set_state(bad), Error);
  bad = saved;
  bad.viscous_stresses[3].xy = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(dynamics.set_state(bad), Error);
}

void expect_refused(const Viscosity& viscosity, const std::string& text) {
  try {
    check_material({.viscosity = viscosity}, "body");
    ADD_FAILURE() << "taken: " << text;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(Prony, SeriesThatAreNoneAreRefusedWithTheirBound) {
  expect_refused({{0.6, 0.4}, {1.0, 2.0}}, "a sum < 1");
  expect_refused({{-0.1}, {1.0}}, "numbers >= 0");
  expect_refused({{1.0}, {1.0}}, "< 1");
  expect_refused({{0.5}, {0.0}}, "numbers > 0");
  expect_refused({{0.5}, {std::numeric_limits<double>::infinity()}}, "numbers > 0");
  expect_refused({{0.5}, {}}, "as many as fractions, 1");
  EXPECT_NO_THROW(check_material({.viscosity = three_terms}, "body"));
}

}  // namespace
}  // namespace palpate::fem::test
