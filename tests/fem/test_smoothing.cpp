// Smoothed tets. Oracles: the matrix at rest written out from the definition by Eigen, differences of
// energies and of forces, uniform strain, beam theory.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <map>

#include "fem/meshes.hpp"
#include "fem/tissue.hpp"
#include "fem/volume_patches.hpp"
#include "support/meshes.hpp"

namespace palpate::fem::test {
namespace {

Material smoothed(double nu, MaterialModel model = MaterialModel::corotational) {
  return {.young_modulus = 2e4,
          .poisson_ratio = nu,
          .model = model,
          .mooney_fraction = 0.3,
          .elements = ElementKind::smoothed};
}

std::vector<Material> materials() {
  std::vector<Material> list{smoothed(0.0), smoothed(0.45), smoothed(0.4, MaterialModel::stable_neo_hookean),
                             smoothed(0.49, MaterialModel::mooney_rivlin)};
  list.push_back(smoothed(0.45, MaterialModel::stable_neo_hookean));
  list.back().fibres = {
      .direction = {1.0, 2.0, 0.0}, .stiffness = 1e4, .exponent = 1.0, .active_stress = 5e3};
  return list;
}

constexpr Vec3 size{0.5, 0.375, 0.375};

/// An irregular box of smoothed tets.
struct Box {
  explicit Box(const Material& m, std::array<int, 3> cells = {3, 2, 2})
      : bodies(single_body(irregular_box_mesh(cells, size, 0.2))),
        elements(bodies, std::vector<Material>(1, m), std::vector<std::uint8_t>(1, 0)) {}
  void update(std::span<const Vec3> positions) { elements.update(parallel::Threads(1), positions); }
  [[nodiscard]] double energy() const {
    double sum = 0.0;
    for (Index e = 0; e < elements.size(); ++e) sum += elements.energy(e);
    return sum;
  }
  Bodies bodies;
  Elements elements;
};

/// K at rest from the definition: a B matrix of six strains per edge, point and patch, the mean of those of
/// the tets there, with 2 mu eps : eps of edges, lambda tr^2 of points with lambda up to 4 mu, and of patches
/// with the rest.
Eigen::MatrixXd stiffness_by_definition(const Bodies& bodies, const Material& m) {
  const double mu = m.young_modulus / (2.0 * (1.0 + m.poisson_ratio));
  const double lambda =
      m.young_modulus * m.poisson_ratio / ((1.0 + m.poisson_ratio) * (1.0 - 2.0 * m.poisson_ratio));
  const auto n = 3 * static_cast<Eigen::Index>(bodies.points_rest().size());
  struct Sum {
    double volume = 0.0;
    Eigen::MatrixXd strains;
  };
  std::map<std::vector<Index>, Sum> sums;  // by one point, two points, or a patch and two numbers
  std::vector<PatchTet> patch_tets;
  for (const Tet& tet : bodies.tets()) patch_tets.push_back({tet, 0});
  const std::vector<std::uint32_t> patches = volume_patches(patch_tets);
  for (std::size_t t = 0; t < patches.size(); ++t) {
    const Tet& tet = bodies.tets()[t];
    Eigen::Matrix4d corners;
    for (int k = 0; k < 4; ++k) {
      const Vec3& p = at(bodies.points_rest(), at(tet, k));
      corners.row(k) << 1.0, p.x, p.y, p.z;
    }
    const double volume = std::abs(corners.determinant()) / 6.0;
    const Eigen::Matrix4d inverted = corners.inverse();
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(6, n);
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector3d g = inverted.block<3, 1>(1, k);
      const Eigen::Index c = Eigen::Index{3} * at(tet, k);
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        b(i, c + i) += g[i];
        b(3 + i, c + i) += g[j] / std::sqrt(2.0);
        b(3 + i, c + j) += g[i] / std::sqrt(2.0);
      }
    }
    const auto add = [&](const std::vector<Index>& domain, double fraction) {
      Sum& sum = sums[domain];
      if (sum.strains.size() == 0) sum.strains = Eigen::MatrixXd::Zero(6, n);
      sum.strains += fraction * volume * b;
      sum.volume += fraction * volume;
    };
    add({static_cast<Index>(patches[t]), -1, -1}, 1.0);
    for (int i = 0; i < 4; ++i) {
      add({at(tet, i)}, 1.0 / 4.0);
      for (int j = i + 1; j < 4; ++j)
        add({std::min(at(tet, i), at(tet, j)), std::max(at(tet, i), at(tet, j))}, 1.0 / 6.0);
    }
  }
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  const double of_points = std::min(lambda, 4.0 * mu);
  for (const auto& [domain, sum] : sums) {
    if (domain.size() == 2) {
      k += 2.0 * mu / sum.volume * sum.strains.transpose() * sum.strains;
    } else {
      const Eigen::RowVectorXd trace = sum.strains.topRows<3>().colwise().sum();
      k += (domain.size() == 1 ? of_points : lambda - of_points) / sum.volume * trace.transpose() * trace;
    }
  }
  return k;
}

TEST(Smoothing, StiffnessAtRestIsThatOfTheDefinition) {
  for (const double nu : {0.0, 0.3, 0.49}) {
    for (const MaterialModel model : {MaterialModel::corotational, MaterialModel::stable_neo_hookean}) {
      const Material m = smoothed(nu, model);
      Box box(m);
      box.update(box.bodies.points_rest());
      const Eigen::MatrixXd expected = stiffness_by_definition(box.bodies, m);
      const auto x = random_vectors(box.bodies.points_rest().size(), 1.0, 3);
      const auto found = unpadded(box.elements.multiply(parallel::Threads(2), padded(x)));
      EXPECT_LT((to_eigen(found) - expected * to_eigen(x)).norm(), 1e-12 * (expected * to_eigen(x)).norm())
          << nu;
    }
  }
}

TEST(Smoothing, ForcesAreTheDerivativeOfTheEnergy) {
  for (const Material& m : materials()) {
    for (const double amplitude : {0.01, 0.1}) {  // of cells of 0.16: with inverted tets
      Box box(m);
      box.elements.set_ambient(std::vector<double>(1, amplitude > 0.05 ? 3e3 : 0.0));
      const auto middle = noisy(box.bodies, amplitude, 5);
      box.update(middle);
      const auto forces = point_forces(box.elements);
      const auto motion = random_vectors(middle.size(), 1.0, 6);
      double work = 0.0;
      for (std::size_t i = 0; i < motion.size(); ++i) work -= dot(forces[i], motion[i]);
      const auto energy_at = [&](double s) {
        auto positions = middle;
        for (std::size_t i = 0; i < motion.size(); ++i) positions[i] += s * motion[i];
        box.update(positions);
        return box.energy();
      };
      constexpr double h = 1e-6;
      const double slope = (energy_at(h) - energy_at(-h)) / (2.0 * h);
      EXPECT_NEAR(work, slope, 1e-6 * std::abs(slope)) << static_cast<int>(m.model) << ", " << amplitude;
      EXPECT_LT(length(total(forces)), 1e-12 * largest(forces) * static_cast<double>(forces.size()));
    }
  }
}

/// K' times random vectors against differences of the forces, relative, at these positions.
double derivative_error(Box& box, const std::vector<Vec3>& middle) {
  const auto motion = random_vectors(middle.size(), 1.0, 8);
  box.update(middle);
  const auto product = unpadded(box.elements.multiply(parallel::Threads(1), padded(motion)));
  const auto forces_at = [&](double s) {
    auto positions = middle;
    for (std::size_t i = 0; i < motion.size(); ++i) positions[i] += s * motion[i];
    box.update(positions);
    return to_eigen(point_forces(box.elements));
  };
  constexpr double h = 1e-5;
  const Eigen::VectorXd slope = (forces_at(-h) - forces_at(h)) / (2.0 * h);
  return (to_eigen(product) - slope).norm() / slope.norm();
}

/// At rotated rest positions, where no eigenvalue is negative.
TEST(Smoothing, ProductsAreTheDerivativeOfTheForces) {
  for (Material m : materials()) {
    m.fibres.stiffness = 0.0;  // its force has a kink at rest
    Box box(m);
    box.elements.set_activations(std::vector<double>(1, 0.7));
    std::mt19937_64 random(7);
    const Matrix3 turn = random_rotation(random);
    const auto middle = mapped(box.bodies, [&](const Vec3& p) { return turn * p; });
    EXPECT_LT(derivative_error(box, middle), 2e-4) << static_cast<int>(m.model);
  }
}

/// Corotational tissue, rotated and with three different stretches: twists have positive stiffness. At fixed
/// R the error would be 0.1 or more.
TEST(Smoothing, ProductsAreTheDerivativeOfTheForcesOfWhatIsStretched) {
  for (const double nu : {0.0, 0.3, 0.49}) {
    Box box(smoothed(nu));
    std::mt19937_64 random(11);
    const Matrix3 turn = random_rotation(random);
    const auto middle = mapped(box.bodies, [&](const Vec3& p) {
      const Vec3 bent{1.5 * p.x + 0.1 * p.y * p.y, 1.3 * p.y + 0.2 * p.z, 1.1 * p.z};
      return turn * bent;
    });
    EXPECT_LT(derivative_error(box, middle), 1e-6) << nu;
  }
}

/// The matrix in float by rows against the product in double, at strains where blocks of all kinds are full.
TEST(Smoothing, RowsOfTheMatrixAreThoseOfTheProduct) {
  for (const Material& m : materials()) {
    Box box(m, {4, 3, 3});
    const std::vector<std::uint8_t> free(box.bodies.points_rest().size(), 1);
    const std::vector<double> diagonal(free.size(), 1.0);
    box.update(noisy(box.bodies, 0.02, 9));
    BlockMatrix matrix(box.elements, free);
    matrix.assemble(parallel::Threads(2), diagonal);
    const auto x = random_vectors(free.size(), 1.0, 10);
    const auto expected = unpadded(box.elements.multiply(parallel::Threads(1), padded(x)));
    std::vector<Vec3> found(free.size());
    for (Index p = 0; p < matrix.size(); ++p) {
      for (std::size_t k = 0; k < matrix.columns(p).size(); ++k)
        at(found, p) += matrix.block(p, k) * x[matrix.columns(p)[k]];
      at(found, p) -= at(x, p);
    }
    EXPECT_LT(largest_distance(found, expected), 2e-6 * largest(expected) * 10.0);
  }
}

TEST(Smoothing, UniformStrainHasUniformStressAndNoForcesInside) {
  for (Material m : materials()) {
    m.fibres = {};
    Box box(m, {4, 3, 3});
    const auto positions = mapped(box.bodies, [](const Vec3& p) {
      return Vec3{1.02 * p.x + 0.01 * p.y, 0.99 * p.y - 0.02 * p.z, 0.01 * p.x + 1.01 * p.z};
    });
    box.update(positions);
    const auto forces = point_forces(box.elements);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      if (on_surface(box.bodies.points_rest()[i], size)) continue;
      EXPECT_LT(length(forces[i]), 1e-11 * largest(forces));
    }
    const TissueState state = tissue_of_tets(parallel::Threads(1), box.bodies, box.elements, positions);
    Material plain = m;
    plain.elements = ElementKind::linear;
    const Elements expected(box.bodies, std::vector<Material>(1, plain), std::vector<std::uint8_t>(1, 0));
    const TissueState uniform = tissue_of_tets(parallel::Threads(1), box.bodies, expected, positions);
    // At strains of some percent the split by Lame's constants is the same law to second order only.
    const double bound = m.model == MaterialModel::corotational ? 1e-10 : 1e-9;
    for (std::size_t t = 0; t < state.size(); ++t) {
      EXPECT_NEAR(state.von_mises[t], uniform.von_mises[t], bound * uniform.von_mises[t]);
      EXPECT_NEAR(state.energy_density[t], uniform.energy_density[t], bound * uniform.energy_density[t]);
    }
  }
}

/// Where strain is uniform, forces of an ambient pressure are those on the triangles of the surface. If the
/// body turns, they turn with it, as the derivative says: a uniform stretch has no negative eigenvalue.
TEST(Smoothing, AmbientPressureIsThatOnTheSurfaceAndTurnsWithIt) {
  constexpr double pressure = 2e3;
  std::mt19937_64 random(17);
  for (const Material& m : materials()) {
    Box box(m, {4, 3, 3});
    const Matrix3 turn = random_rotation(random);
    const auto positions = mapped(box.bodies, [&](const Vec3& p) { return 1.05 * (turn * p); });
    box.update(positions);
    auto expected = point_forces(box.elements);
    for (const Triangle& t : box.bodies.triangles()) {
      const Vec3& corner = at(positions, t[0]);
      const Vec3 area = 0.5 * cross(at(positions, t[1]) - corner, at(positions, t[2]) - corner);
      for (const Index p : t) at(expected, p) += (-pressure / 3.0) * area;
    }
    box.elements.set_ambient(std::vector<double>(1, pressure));
    box.update(positions);
    const auto forces = point_forces(box.elements);
    for (std::size_t i = 0; i < forces.size(); ++i)
      EXPECT_LT(length(forces[i] - expected[i]), 1e-11 * largest(forces));
    if (m.fibres.any()) continue;
    const Vec3 axis{0.3, -0.5, 0.8};
    std::vector<Vec3> motion;
    for (const Vec3& p : positions) motion.push_back(cross(axis, p));
    const auto product = unpadded(box.elements.multiply(parallel::Threads(1), padded(motion)));
    for (std::size_t i = 0; i < forces.size(); ++i)
      EXPECT_LT(length(product[i] + cross(axis, forces[i])), 1e-10 * largest(forces));
  }
}

/// K' of all points, from the product.
Eigen::MatrixXd dense_tangent(const Box& box) {
  const std::size_t points = box.bodies.points_rest().size();
  Eigen::MatrixXd k(3 * points, 3 * points);
  for (std::size_t c = 0; c < 3 * points; ++c) {
    std::vector<Vec3> one(points);
    (c % 3 == 0 ? one[c / 3].x : c % 3 == 1 ? one[c / 3].y : one[c / 3].z) = 1.0;
    k.col(static_cast<Eigen::Index>(c)) =
        to_eigen(unpadded(box.elements.multiply(parallel::Threads(1), padded(one))));
  }
  return k;
}

/// Muscles that contract freely hardly resist bending. Where domains for volume have negative eigenvalues,
/// those for shape make up for them.
TEST(Smoothing, TangentOfAMuscleHasNoNegativeEigenvalues) {
  for (const double nu : {0.3, 0.4, 0.45, 0.49}) {
    for (const double tension : {0.5, 1.5}) {  // of Young's modulus
      for (const double amplitude : {0.0, 0.005, 0.03}) {
        Material m = smoothed(nu, MaterialModel::stable_neo_hookean);
        m.fibres = {
            .direction = {1.0, 2.0, 0.5}, .stiffness = 0.0, .active_stress = tension * m.young_modulus};
        Box box(m, {5, 4, 2});
        box.elements.set_activations(std::vector<double>(1, 1.0));
        const Vec3 fibre = (1.0 / length(m.fibres.direction)) * m.fibres.direction;
        const double side = tension > 1.0 ? 1.25 : 1.13;
        auto positions = noisy(box.bodies, amplitude, 9);
        for (Vec3& p : positions) p = side * p + ((0.95 / (side * side) - side) * dot(fibre, p)) * fibre;
        box.update(positions);
        const Eigen::VectorXd values =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense_tangent(box)).eigenvalues();
        EXPECT_GT(values[0], -1e-9 * values[values.size() - 1]) << nu << ", " << tension << ", " << amplitude;
      }
    }
  }
}

/// A body that hangs at rest: the holding force is its weight, also in the step before rest.
TEST(Smoothing, WhatHoldsAHangingBodyIsItsWeight) {
  for (const Material& m : {smoothed(0.45), smoothed(0.45, MaterialModel::stable_neo_hookean)}) {
    const Bodies bodies = single_body(irregular_box_mesh({3, 2, 2}, size, 0.2));
    Dynamics dynamics =
        Scene{m, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), 1}.dynamics(bodies);
    dynamics.find_constrained_elements();
    const Vec3 gravity{9.81, 0.0, 0.0};
    std::vector<Vec3> forces(bodies.points_rest().size());
    for (const int steps : {1, 400}) {
      Vec3 before;
      for (int n = 0; n < steps; ++n) {
        before = momentum(dynamics);
        dynamics.begin_step(0.01, gravity, {});
        dynamics.solve(std::span<const Coupling>(), {.tolerance = 1e-10, .max_iterations = 2000});
        for (int k = 0; k < 8 && dynamics.relinearise_tissue(1e-10); ++k)
          dynamics.solve(std::span<const Coupling>(), {.tolerance = 1e-10, .max_iterations = 2000});
        dynamics.holding_forces(gravity, {}, forces);
        dynamics.end_step();
      }
      double mass = 0.0;
      for (const double each : dynamics.point_masses()) mass += each;
      const Vec3 change = 100.0 * (momentum(dynamics) - before);
      EXPECT_LT(length(total(forces) + mass * gravity - change), 1e-6 * mass * 9.81) << steps;
    }
  }
}

TEST(Smoothing, AFreeSpinKeepsItsMomentumAndGainsNoEnergy) {
  for (const Material& m : {smoothed(0.45), smoothed(0.4, MaterialModel::stable_neo_hookean)}) {
    const Bodies bodies = single_body(irregular_box_mesh({3, 2, 2}, size, 0.2));
    Dynamics dynamics = Scene{m, {}, 1}.dynamics(bodies);
    std::vector<Vec3> velocities = random_vectors(bodies.points_rest().size(), 0.3, 12);
    for (std::size_t i = 0; i < velocities.size(); ++i)
      velocities[i] += cross(Vec3{0.0, 3.0, 1.0}, bodies.points_rest()[i]);
    dynamics.set_velocities(velocities);
    const Vec3 start = momentum(dynamics);
    double energy = dynamics.kinetic_energy() + dynamics.elastic_energy();
    for (int n = 0; n < 60; ++n) {
      dynamics.step(0.005, {}, {}, {}, 1e-8, 2000);
      const double now = dynamics.kinetic_energy() + dynamics.elastic_energy();
      EXPECT_LT(now, energy * (1.0 + 1e-6));
      energy = now;
    }
    EXPECT_LT(length(momentum(dynamics) - start), 1e-6 * length(start));
  }
}

TEST(Smoothing, HasTheSameBitsForAllThreads) {
  for (const Material& m : materials()) {
    const Bodies bodies = single_body(irregular_box_mesh({6, 5, 5}, size, 0.2));
    std::vector<Vec3> first;
    for (const int threads : {1, 2, 3}) {
      Dynamics dynamics =
          Scene{m, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), threads}.dynamics(bodies);
      for (int n = 0; n < 4; ++n) dynamics.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-4, 300);
      if (threads == 1) first.assign(dynamics.positions().begin(), dynamics.positions().end());
      EXPECT_TRUE(std::ranges::equal(first, dynamics.positions())) << threads;
    }
  }
}

/// Noise of half a cell, a mirrored and a flat body: at nu = 0.4 all recover.
TEST(Smoothing, InvertedTissueComesBack) {
  const Bodies bodies = single_body(box_mesh({4, 3, 3}, size));
  Material m = smoothed(0.4);
  m.stiffness_damping = 0.002;
  const std::vector<std::vector<Vec3>> starts{noisy(bodies, 0.06, 3),
                                              mapped(bodies,
                                                     [](const Vec3& p) {
                                                       return Vec3{p.x, p.y, -p.z};
                                                     }),
                                              mapped(bodies, [](const Vec3& p) {
                                                return Vec3{p.x, p.y, 0.0};
                                              })};
  for (const auto& start : starts) {
    Dynamics dynamics = Scene{m, {}, 1}.dynamics(bodies);
    dynamics.set_positions(start);
    EXPECT_GT(dynamics.inverted_elements(), 0);
    for (int n = 0; n < 300; ++n) dynamics.step(0.01, {}, {}, {}, 1e-4, 300);
    EXPECT_EQ(dynamics.inverted_elements(), 0);
  }
}

/// Stiffness of a cube compressed by 1 % between rough plates, over that of a bar with free sides.
double squeezed_stiffness(int cells, double nu, ElementKind kind) {
  const Bodies bodies = single_body(palpate::test::box_mesh({cells, cells, cells}, {}, {1.0, 1.0, 1.0}));
  Material m = smoothed(nu);
  m.elements = kind;
  Dynamics dynamics =
      Scene{m, select(bodies, [](const Vec3& p) { return p.z == 0.0 || p.z == 1.0; }), 2}.dynamics(bodies);
  constexpr double squeeze = 1e-4;
  dynamics.set_positions(mapped(bodies, [&](const Vec3& p) {
    return Vec3{p.x, p.y, p.z == 1.0 ? 1.0 - squeeze : p.z};
  }));
  settle(dynamics, std::vector<Vec3>(bodies.points_rest().size()), 2, 1e-9);
  const double stiffness = 2.0 * dynamics.elastic_energy() / (squeeze * squeeze * m.young_modulus);
  std::printf("nu %.3f, %d cells, %s: %.4f\n", nu, cells,
              element_kind_names[static_cast<std::size_t>(kind)].data(), stiffness);
  return stiffness;
}

/// Oracle: an independent code in NumPy on the same meshes, and the limit of its values for 4, 6 and 8 cells.
TEST(Locking, ASqueezedBlockOfSmoothedTetsDoesNotLock) {
  EXPECT_NEAR(squeezed_stiffness(4, 0.49, ElementKind::smoothed), 1.2763, 1e-3);
  EXPECT_NEAR(squeezed_stiffness(4, 0.499, ElementKind::smoothed), 1.2894, 1e-3);
  const double limit = 1.222;
  const double limit_at_499 = 1.233;
  EXPECT_NEAR(squeezed_stiffness(8, 0.49, ElementKind::smoothed), limit, 0.02 * limit);
  EXPECT_NEAR(squeezed_stiffness(8, 0.499, ElementKind::smoothed), limit_at_499, 0.02 * limit_at_499);
  EXPECT_GT(squeezed_stiffness(8, 0.49, ElementKind::linear), 1.3 * limit);
  EXPECT_GT(squeezed_stiffness(8, 0.499, ElementKind::linear), 2.5 * limit_at_499);
}

constexpr double beam_length = 1.0;
constexpr double beam_side = 0.1;

/// Tip deflection of a square cantilever of ten times its height under a load at its end, over that of
/// Timoshenko (Cowper's coefficient).
double tip_ratio(const TetMesh& mesh, double nu) {
  const Bodies bodies = single_body(mesh);
  Material m = smoothed(nu);
  Dynamics dynamics = Scene{m, select(bodies, [](const Vec3& p) { return p.x < 1e-9; }), 2}.dynamics(bodies);
  constexpr double load = 1e-4;
  const auto rest = bodies.points_rest();
  std::vector<Vec3> forces(rest.size());
  double area = 0.0;
  for (const Triangle& t : bodies.triangles()) {
    if (!std::ranges::all_of(t, [&](Index p) { return at(rest, p).x > beam_length - 1e-9; })) continue;
    const Vec3& corner = at(rest, t[0]);
    const double own = 0.5 * length(cross(at(rest, t[1]) - corner, at(rest, t[2]) - corner));
    for (const Index p : t) at(forces, p).z += own / 3.0;
    area += own;
  }
  for (Vec3& f : forces) f = (load / area) * f;
  settle(dynamics, forces, 1, 1e-8, 20000);
  double work = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i)
    work += forces[i].z / load * (dynamics.positions()[i].z - rest[i].z);
  const double inertia = std::pow(beam_side, 4) / 12.0;
  const double shear_modulus = m.young_modulus / (2.0 * (1.0 + nu));
  const double kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  const double theory = load * std::pow(beam_length, 3) / (3.0 * m.young_modulus * inertia) +
                        load * beam_length / (kappa * shear_modulus * beam_side * beam_side);
  std::printf("nu %.2f, %zu tets: %.4f of beam theory\n", nu, mesh.tets.size(), work / theory);
  return work / theory;
}

TEST(Locking, ACantileverOfTwoCellsAcrossBendsAsBeamTheorySays) {
  const Vec3 beam{beam_length, beam_side, beam_side};
  for (const double nu : {0.3, 0.45, 0.49, 0.499}) {
    EXPECT_NEAR(tip_ratio(box_mesh({20, 2, 2}, beam), nu), 1.0, 0.05);
    EXPECT_NEAR(tip_ratio(palpate::test::box_mesh({20, 2, 2}, {}, beam), nu), 1.0, 0.05);
  }
  // Linear tets reach 0.67 and 0.50 at 0.3, and 0.60 and 0.10 at 0.49.
}

}  // namespace
}  // namespace palpate::fem::test
