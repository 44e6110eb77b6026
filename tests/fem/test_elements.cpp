#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include <palpate/error.hpp>

#include "fem/elements.hpp"
#include "fem/lumping.hpp"
#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

const Material soft{2e4, 0.35, 1000.0, 0.0, 0.0};

Elements elements_of(const Bodies& bodies, const Material& material = soft) {
  const auto count = static_cast<std::size_t>(bodies.body_count());
  return Elements(bodies, std::vector<Material>(count, material), std::vector<std::uint8_t>(count, 0));
}

std::vector<Bodies> several_meshes() {
  std::vector<Bodies> meshes;
  meshes.push_back(single_body(unit_tet_mesh()));
  meshes.push_back(single_body(box_mesh({3, 2, 1}, {0.3, 0.2, 0.1})));
  meshes.push_back(single_body(irregular_box_mesh({4, 4, 4}, {1.0, 2.0, 0.5}, 0.2)));
  return meshes;
}

TEST(Elements, HaveExactlyNoForceAtRest) {
  for (const Bodies& bodies : several_meshes()) {
    Elements elements = elements_of(bodies);
    elements.update(one_thread, bodies.points_rest());
    EXPECT_EQ(largest(point_forces(elements)), 0.0);
    EXPECT_EQ(total_energy(elements, bodies.points_rest()), 0.0);
  }
}

/// Several chunks of elements; points are in one chunk or many. The bits are the same for all thread counts.
TEST(Elements, ForcesOnPointsAreTheSumsOfThoseOnCorners) {
  const Bodies bodies = single_body(irregular_box_mesh({6, 5, 5}, {1.0, 2.0, 0.5}, 0.2));
  const auto positions = noisy(bodies, 0.02, 4);
  Elements elements = elements_of(bodies);
  ASSERT_GT(elements.size(), 5 * static_cast<Index>(CornerSums::chunk));
  std::vector<simd::Padded3> corners(4 * static_cast<std::size_t>(elements.size()));
  elements.update(one_thread, positions, corners);
  const auto forces = point_forces(elements);
  std::vector<Vec3> sums(positions.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const Vec3 force{corners[c].x, corners[c].y, corners[c].z};
    at(sums, elements.corners()[c / 4][c % 4]) += force;
  }
  EXPECT_GT(largest(forces), 0.0);
  for (std::size_t i = 0; i < sums.size(); ++i)
    EXPECT_LT(length(forces[i] - sums[i]), 1e-13 * largest(forces));
  for (const int threads : {2, 3}) {
    elements.update(parallel::Threads(threads), positions);
    EXPECT_EQ(point_forces(elements), forces) << threads;
  }
}

/// Each body's tets, once each; tets that share points have close numbers.
TEST(Elements, AreNumberedBodyByBodyWhatIsNearInSpaceNearEachOther) {
  Bodies bodies;
  bodies.add("first", irregular_box_mesh({6, 6, 6}, {1.0, 1.0, 1.0}, 0.2));
  bodies.add("second", irregular_box_mesh({3, 3, 3}, {1.0, 1.0, 1.0}, 0.2));
  const Elements elements = elements_of(bodies);
  ASSERT_EQ(static_cast<std::size_t>(elements.size()), bodies.tets().size());
  std::vector<int> times(bodies.tets().size());
  for (Index e = 0; e < elements.size(); ++e) {
    const Index tet = at(elements.tet_of_element(), e);
    ++at(times, tet);
    EXPECT_EQ(at(elements.corners(), e), at(bodies.tets(), tet));
    const Range tets = at(bodies.bodies(), at(elements.body_of_element(), e)).tets;
    EXPECT_TRUE(tet >= tets.begin && tet < tets.end) << tet;
    if (e == 0) continue;
    EXPECT_GE(at(elements.body_of_element(), e), at(elements.body_of_element(), e - 1));
  }
  EXPECT_EQ(std::ranges::count(times, 1), static_cast<std::ptrdiff_t>(times.size()));
}

TEST(Elements, HaveNoForceUnderRigidMotion) {
  std::mt19937_64 random(5);
  for (const Bodies& bodies : several_meshes()) {
    Elements elements = elements_of(bodies);
    for (int trial = 0; trial < 20; ++trial) {
      const Matrix3 r = random_rotation(random);
      const Vec3 t = random_vector(random, 10.0);
      const auto moved = mapped(bodies, [&](const Vec3& p) { return r * p + t; });
      elements.update(one_thread, moved);
      // Scale: the force of a strain of 1 is about E times an area of at most 4 m^2.
      EXPECT_LT(largest(point_forces(elements)), 1e-12 * soft.young_modulus * 4.0);
      EXPECT_LT(total_energy(elements, moved), 1e-24 * soft.young_modulus);
    }
  }
}

TEST(Elements, MatchHookesLawForSmallStrain) {
  // Energy of a uniform small strain: V (mu eps:eps + lambda/2 tr^2 eps), with E and nu turned into stiffness
  // by hand.
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 3}, {1.0, 1.0, 1.0}, 0.2));
  const Elements elements = elements_of(bodies, {3e4, 0.25, 1000.0, 0.0, 0.0});
  constexpr double strain = 1e-6;
  // Uniaxial strain: modulus E (1 - nu) / ((1 + nu)(1 - 2 nu)) = 36000.
  const auto pulled = mapped(bodies, [&](const Vec3& p) { return Vec3{p.x * (1.0 + strain), p.y, p.z}; });
  EXPECT_NEAR(total_energy(elements, pulled) / (0.5 * 36000.0 * strain * strain), 1.0, 1e-6);
  // Simple shear: modulus E / (2 (1 + nu)) = 12000.
  const auto sheared = mapped(bodies, [&](const Vec3& p) { return Vec3{p.x + strain * p.y, p.y, p.z}; });
  EXPECT_NEAR(total_energy(elements, sheared) / (0.5 * 12000.0 * strain * strain), 1.0, 1e-5);
}

/// Central differences of the energy, along every coordinate.
void expect_force_is_derivative(Elements& elements, std::vector<Vec3> positions) {
  elements.update(one_thread, positions);
  const auto forces = point_forces(elements);
  constexpr double step = 1e-6;
  const double scale = largest(forces);
  ASSERT_GT(scale, 0.0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      const double center = positions[i].*axis;
      positions[i].*axis = center + step;
      const double above = total_energy(elements, positions);
      positions[i].*axis = center - step;
      const double below = total_energy(elements, positions);
      positions[i].*axis = center;
      EXPECT_NEAR(forces[i].*axis, -(above - below) / (2.0 * step), 1e-7 * scale) << "point " << i;
    }
  }
}

void expect_force_is_derivative(const Bodies& bodies, std::vector<Vec3> positions) {
  Elements elements = elements_of(bodies);
  expect_force_is_derivative(elements, std::move(positions));
}

TEST(Elements, ForceIsMinusTheDerivativeOfTheEnergy) {
  std::mt19937_64 random(6);
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, {1.0, 1.0, 1.0}, 0.2));
  for (int trial = 0; trial < 10; ++trial) {
    const Matrix3 r = random_rotation(random);
    expect_force_is_derivative(bodies, mapped(bodies, [&](const Vec3& p) {
                                 return r * (p + random_vector(random, 0.1)) + Vec3{3.0, -2.0, 1.0};
                               }));
  }
}

TEST(Elements, ForceIsMinusTheDerivativeOfTheEnergyWhereInverted) {
  const Bodies bodies = single_body(unit_tet_mesh());
  for (const double height : {0.3, 0.01, 0.0, -0.2, -0.6}) {
    auto positions = mapped(bodies, [&](const Vec3& p) {
      return Vec3{p.x + 0.3 * p.y, 1.1 * p.y, height * p.z};
    });
    expect_force_is_derivative(bodies, positions);
  }
}

TEST(Elements, ForceIsMinusTheDerivativeOfTheEnergyWithALowerBulkModulus) {
  const Bodies bodies = single_body(unit_tet_mesh());
  for (const double fraction : {0.0, 0.3}) {
    for (const double height : {0.7, 0.0, -0.6}) {
      Elements elements = elements_of(bodies);
      elements.set_bulk_fraction(0, fraction);
      expect_force_is_derivative(elements, mapped(bodies, [&](const Vec3& p) {
                                   return Vec3{p.x + 0.3 * p.y, 1.1 * p.y, height * p.z};
                                 }));
    }
  }
}

/// Without a bulk modulus the force on a deformed tet is along R - F. On that straight line R stays the
/// nearest rotation, so the tet reaches rest.
TEST(Elements, WithoutABulkModulusATetReturnsToRestFromAnyState) {
  const Bodies bodies = single_body(unit_tet_mesh());
  Elements elements = elements_of(bodies, {2e4, 0.49, 1000.0, 0.0, 0.0});
  elements.set_bulk_fraction(0, 0.0);
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::vector<Vec3> positions = random_vectors(4, 3.0, 100 + seed);
    if (seed % 3 == 1) {
      for (Vec3& p : positions) p.z = 0.0;
    }
    const double first = total_energy(elements, positions);
    double energy = first;
    for (int step = 0; step < 12; ++step) {
      elements.update(one_thread, positions);
      const std::vector<Vec3> forces = point_forces(elements);
      for (std::size_t i = 0; i < 4; ++i) positions[i] += (1.0 / (8.0 * soft.young_modulus)) * forces[i];
      const double next = total_energy(elements, positions);
      ASSERT_LT(next, energy) << seed << ", " << step;
      energy = next;
    }
  }
}

TEST(Elements, ForcesSumToZeroInForceAndTorque) {
  const Bodies bodies = single_body(irregular_box_mesh({3, 3, 3}, {1.0, 1.0, 1.0}, 0.2));
  Elements elements = elements_of(bodies);
  for (Index e = 0; e < elements.size(); e += 3) elements.set_bulk_fraction(e, 0.25 * (e % 4));
  const auto positions = noisy(bodies, 0.3, 7);  // some elements are inverted
  elements.update(one_thread, positions);
  const auto forces = point_forces(elements);
  Vec3 torque;
  for (std::size_t i = 0; i < forces.size(); ++i) torque += cross(positions[i], forces[i]);
  EXPECT_LT(length(total(forces)), 1e-12 * largest(forces));
  EXPECT_LT(length(torque), 1e-11 * largest(forces));
}

TEST(Elements, StiffnessIsExactlySymmetricAndPositiveWithTranslationsAsNullSpace) {
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, {1.0, 1.0, 1.0}, 0.2));
  Elements elements = elements_of(bodies);
  const auto positions = noisy(bodies, 0.1, 8);
  elements.update(one_thread, positions);
  const Eigen::MatrixXd k = dense_stiffness(elements, positions.size());
  EXPECT_EQ((k - k.transpose()).cwiseAbs().maxCoeff(), 0.0);
  const double scale = k.cwiseAbs().maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd translation = Eigen::VectorXd::Zero(k.rows());
    for (Eigen::Index i = axis; i < k.rows(); i += 3) translation[i] = 1.0;
    EXPECT_LT((k * translation).cwiseAbs().maxCoeff(), 1e-13 * scale);
  }
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  EXPECT_GT(values[0], -1e-12 * scale);
  EXPECT_GT(values[6], 1e-4 * scale) << "more than six rigid modes";
}

/// At a rotated rest configuration the neglected derivative of R is zero: K' is the whole derivative.
TEST(Elements, StiffnessIsMinusTheDerivativeOfTheForceAtRest) {
  std::mt19937_64 random(9);
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, {1.0, 1.0, 1.0}, 0.2));
  Elements elements = elements_of(bodies);
  const Matrix3 r = random_rotation(random);
  auto positions = mapped(bodies, [&](const Vec3& p) { return r * p; });
  elements.update(one_thread, positions);
  const Eigen::MatrixXd k = dense_stiffness(elements, positions.size());
  constexpr double step = 1e-6;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3 center = positions[i];
    const auto forces_at = [&](const Vec3& p) {
      positions[i] = p;
      elements.update(one_thread, positions);
      return to_eigen(point_forces(elements));
    };
    const Eigen::VectorXd slope =
        (forces_at(center + Vec3{0.0, step, 0.0}) - forces_at(center - Vec3{0.0, step, 0.0})) / (2.0 * step);
    positions[i] = center;
    const Eigen::VectorXd column = k.col(3 * static_cast<Eigen::Index>(i) + 1);
    EXPECT_LT((slope + column).cwiseAbs().maxCoeff(), 1e-6 * k.cwiseAbs().maxCoeff()) << "point " << i;
  }
}

TEST(Elements, LeaveOutObstaclesAndKeepTheOrderOfTheOthers) {
  Bodies bodies;
  bodies.add("first", unit_tet_mesh());
  bodies.add("plate", box_mesh({1, 1, 1}, {1.0, 1.0, 1.0}));
  bodies.add("last", unit_tet_mesh(2.0));
  const std::vector<Material> materials(3, soft);
  const Elements elements(bodies, materials, std::vector<std::uint8_t>{0, 1, 0});
  ASSERT_EQ(elements.size(), 2);
  EXPECT_EQ(elements.tet_of_element()[1], 6);
  EXPECT_EQ(elements.body_of_element()[1], 2);
  EXPECT_NEAR(elements.volumes_rest()[0], 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(elements.volumes_rest()[1], 8.0 / 6.0, 1e-14);
}

TEST(LumpedMasses, AddUpToDensityTimesVolume) {
  Bodies bodies;
  bodies.add("box", irregular_box_mesh({3, 3, 3}, {1.0, 2.0, 0.5}, 0.2));
  TetMesh lonely = unit_tet_mesh();
  lonely.points.push_back({5.0, 5.0, 5.0});
  bodies.add("lonely", lonely);
  std::vector<Material> materials(2, soft);
  materials[1].density = 600.0;
  const auto masses = lumped_masses(bodies, materials);
  double box = 0.0;
  for (Index i = 0; i < bodies.bodies()[0].points.end; ++i) box += at(masses, i);
  EXPECT_NEAR(box, 1000.0, 1e-9);
  const Index first = bodies.bodies()[1].points.begin;
  for (Index i = first; i < first + 4; ++i) EXPECT_NEAR(at(masses, i), 25.0, 1e-12);
  EXPECT_EQ(masses.back(), 0.0);
}

TEST(Elements, RefuseATetThatDoublePrecisionCannotHold) {
  TetMesh mesh = box_mesh({1, 1, 1}, {1.0, 1.0, 1.0});
  // Exactly positive volume, far below the smallest double.
  const auto first = static_cast<Index>(mesh.points.size());
  for (const Vec3& p : unit_tet_mesh(1e-120).points) mesh.points.push_back(p);
  mesh.tets.push_back({first, first + 1, first + 2, first + 3});
  const Bodies bodies = single_body(mesh);
  try {
    elements_of(bodies);
    FAIL() << "was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.source(), "body body");
    EXPECT_EQ(error.where(), "tet 5");
  }
}

}  // namespace
}  // namespace palpate::fem::test
