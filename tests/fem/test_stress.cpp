// Strain and stress of tets and points. Oracles: Eigen; affine maps and the corotational law by hand; the
// energy, differentiated by differences.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"
#include "fem/stress.hpp"
#include "fem/symmetric_eigen.hpp"
#include "fem/tissue.hpp"

namespace palpate::fem::test {
namespace {

const Material rubber{.young_modulus = 1e5, .poisson_ratio = 0.3};

Eigen::Matrix3d tensor_to_eigen(const SymmetricTensor& a) {
  return test::to_eigen(to_matrix(a));
}
Eigen::Matrix3d to_eigen_rows(const Tensor& rows) {
  return test::to_eigen(Matrix3{rows});
}

struct LameInDouble {
  explicit LameInDouble(const Material& m)
      : mu(m.young_modulus / (2.0 * (1.0 + m.poisson_ratio))),
        lambda(m.young_modulus * m.poisson_ratio /
               ((1.0 + m.poisson_ratio) * (1.0 - 2.0 * m.poisson_ratio))) {}
  double mu;
  double lambda;
};

/// The corotational Cauchy stress of F = Q U with U symmetric and positive, by the polar decomposition of
/// Eigen.
Eigen::Matrix3d stress_by_hand(const Eigen::Matrix3d& f, const Material& material) {
  const LameInDouble lame(material);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d q = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Matrix3d e = q.transpose() * f - Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d p = q * (2.0 * lame.mu * e + lame.lambda * e.trace() * Eigen::Matrix3d::Identity());
  return p * f.transpose() / f.determinant();
}

TissueState tissue(const Bodies& bodies, const Dynamics& dynamics, std::span<const Vec3> positions) {
  return tissue_of_tets(parallel::Threads(2), bodies, dynamics.elements(), positions);
}

TEST(StressEigen, AgreesWithEigen) {
  std::mt19937_64 random(7);
  std::vector<Eigen::Matrix3d> matrices{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity(),
                                        Eigen::Vector3d(2.0, -1.0, 2.0).asDiagonal()};
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d q = test::to_eigen(random_rotation(random));
    const Vec3 v = random_vector(random, 1.0);
    const double spread = i % 3 == 0 ? 1e-9 : 1.0;  // some with eigenvalues that are nearly equal
    const Eigen::Vector3d values(1.0 + spread * v.x, 1.0 + spread * v.y, i % 2 == 0 ? 1e12 : v.z);
    matrices.push_back(q * values.asDiagonal() * q.transpose());
  }
  for (const Eigen::Matrix3d& m : matrices) {
    const SymmetricMatrix3 a{m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
    const Eigen::Matrix3d exact = test::to_eigen(a);
    const SymmetricEigen ours = symmetric_eigen(a);
    const Eigen::Vector3d theirs = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(exact).eigenvalues();
    const double size = std::max(exact.norm(), 1e-300);
    EXPECT_LT((test::to_eigen(ours.values) - theirs.reverse()).norm(), 1e-14 * size);
    Eigen::Matrix3d v;
    for (int k = 0; k < 3; ++k) v.col(k) = test::to_eigen(ours.vectors[static_cast<std::size_t>(k)]);
    EXPECT_LT((v * test::to_eigen(ours.values).asDiagonal() * v.transpose() - exact).norm(), 1e-14 * size);
    EXPECT_LT((v.transpose() * v - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  }
  EXPECT_TRUE(std::isnan(symmetric_eigen({NAN, 0, 0, 0, 0, 0}).values.x));
}

/// An affine map of the surface of an irregular mesh; the inside is free.
TEST(StressPatchTest, IsUniformInAnyMesh) {
  constexpr Vec3 size{0.3, 0.2, 0.25};
  const Bodies bodies = single_body(irregular_box_mesh({4, 4, 4}, size, 0.25));
  std::mt19937_64 random(3);
  Eigen::Matrix3d u;
  u << 1.001, 5e-4, -3e-4, 5e-4, 0.9992, 7e-4, -3e-4, 7e-4, 1.0004;
  for (const bool turned : {false, true}) {
    const Eigen::Matrix3d f =
        (turned ? test::to_eigen(random_rotation(random)) : Eigen::Matrix3d::Identity()) * u;
    const auto expected = mapped(bodies, [&](const Vec3& p) {
      const Eigen::Vector3d q = f * test::to_eigen(p);
      return Vec3{q.x(), q.y(), q.z()};
    });
    Dynamics dynamics =
        Scene{rubber, select(bodies, [&](const Vec3& p) { return on_surface(p, size); }), 1}.dynamics(bodies);
    std::vector<Vec3> start = expected;
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (!on_surface(bodies.points_rest()[i], size)) start[i] += random_vector(random, 0.005);
    }
    dynamics.set_positions(start);
    settle(dynamics, {}, 60, 1e-14);
    const TissueState state = tissue(bodies, dynamics, dynamics.positions());
    const Eigen::Matrix3d stress = stress_by_hand(f, rubber);
    for (std::size_t t = 0; t < state.size(); ++t)
      ASSERT_LT((tensor_to_eigen(state.stress[t]) - stress).norm(), 1e-10 * stress.norm()) << "tet " << t;
    const Materials materials{rubber};
    const TissueState at_points =
        tissue_of_points(parallel::Threads(2), bodies, dynamics.elements(), materials, state);
    ASSERT_EQ(at_points.size(), bodies.points_rest().size());
    for (std::size_t p = 0; p < at_points.size(); ++p)
      ASSERT_LT((tensor_to_eigen(at_points.stress[p]) - stress).norm(), 1e-10 * stress.norm())
          << "point " << p;
  }
}

/// Dead loads on the end of a bar whose sides are free: P = E (a - 1) along it, b = 1 - nu (a - 1) across.
TEST(StressUniaxial, FollowsTheCorotationalLawWithFreeSides) {
  constexpr Vec3 size{0.4, 0.2, 0.2};
  constexpr double a = 1.3;
  const double b = 1.0 - rubber.poisson_ratio * (a - 1.0);
  const Bodies bodies = single_body(box_mesh({4, 2, 2}, size));
  Dynamics dynamics =
      Scene{rubber, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), 1}.dynamics(bodies);
  const auto start = mapped(bodies, [&](const Vec3& p) { return Vec3{0.97 * a * p.x, b * p.y, b * p.z}; });
  dynamics.set_positions(start);
  const double nominal = rubber.young_modulus * (a - 1.0);
  std::vector<Vec3> forces(start.size());
  for (const Triangle& t : bodies.triangles()) {
    const auto corner = [&](std::size_t i) { return at(bodies.points_rest(), t[i]); };
    if (corner(0).x != size.x || corner(1).x != size.x || corner(2).x != size.x) continue;
    const double area = 0.5 * length(cross(corner(1) - corner(0), corner(2) - corner(0)));
    for (const Index p : t) at(forces, p).x += area / 3.0 * nominal;
  }
  settle(dynamics, forces, 60, 1e-13);
  const TissueState s = tissue(bodies, dynamics, dynamics.positions());
  const double stress = nominal / (b * b);
  for (std::size_t t = 0; t < s.size(); ++t) {
    Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
    expected(0, 0) = stress;
    ASSERT_LT((tensor_to_eigen(s.stress[t]) - expected).norm(), 1e-8 * stress) << "tet " << t;
    EXPECT_NEAR(s.von_mises[t], stress, 1e-8 * stress);
    EXPECT_NEAR(s.pressure[t], -stress / 3.0, 1e-8 * stress);
    EXPECT_NEAR(s.principal_stress[t].x, stress, 1e-8 * stress);
    EXPECT_NEAR(s.principal_stress[t].z, 0.0, 1e-8 * stress);
    EXPECT_NEAR(s.principal_directions[t][0].x, 1.0, 1e-8);
    EXPECT_NEAR(s.energy_density[t], 0.5 * nominal * (a - 1.0), 1e-8 * nominal);
    EXPECT_NEAR(s.volume_ratio[t], a * b * b, 1e-8);
    EXPECT_NEAR(s.strain[t].xx, 0.5 * (a * a - 1.0), 1e-8);
    EXPECT_NEAR(s.strain[t].yy, 0.5 * (b * b - 1.0), 1e-8);
    EXPECT_LT(
        (to_eigen_rows(s.deformation_gradient[t]) - Eigen::Vector3d(a, b, b).asDiagonal().toDenseMatrix())
            .norm(),
        1e-8);
  }
}

/// J sigma F^-T is the derivative of the energy density by F: by differences, also where tissue has yielded.
TEST(Stress, IsTheDerivativeOfTheEnergy) {
  Material plastic = rubber;
  plastic.plastic_yield = 0.01;
  plastic.plastic_creep = 1.0;
  const Bodies bodies = single_body(unit_tet_mesh());
  std::mt19937_64 random(11);
  for (int round = 0; round < 20; ++round) {
    Elements elements(bodies, {plastic}, std::vector<std::uint8_t>{0});
    if (round % 2 == 1) {
      const Vec3 d = random_vector(random, 0.2);
      const Vec3 o = random_vector(random, 0.2);
      elements.set_plastic_strains(std::vector<SymmetricMatrix3>{{d.x, d.y, d.z, o.x, o.y, o.z}});
    }
    Eigen::Matrix3d f = test::to_eigen(random_rotation(random));
    for (int k = 0; k < 3; ++k) f.col(k) += test::to_eigen(random_vector(random, 0.3));
    const auto places = [&](const Eigen::Matrix3d& gradient) {
      return mapped(bodies, [&](const Vec3& p) {
        const Eigen::Vector3d q = gradient * test::to_eigen(p);
        return Vec3{q.x(), q.y(), q.z()};
      });
    };
    Eigen::Matrix3d derivative;
    constexpr double step = 1e-5;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        Eigen::Matrix3d ahead = f;
        Eigen::Matrix3d behind = f;
        ahead(i, j) += step;
        behind(i, j) -= step;
        derivative(i, j) = (elements.energy(0, places(ahead)) - elements.energy(0, places(behind))) /
                           (2.0 * step * elements.volumes_rest()[0]);
      }
    }
    const ElementStress s = stress_of(elements.deformation(0, places(f)));
    if (f.determinant() <= 0.0) {
      EXPECT_TRUE(std::isnan(s.stress.xx));
      continue;
    }
    const Eigen::Matrix3d expected = derivative * f.transpose() / f.determinant();
    EXPECT_LT((test::to_eigen(s.stress) - expected).norm(), 1e-6 * expected.norm()) << "round " << round;
    EXPECT_NEAR(s.energy_density * elements.volumes_rest()[0], elements.energy(0, places(f)),
                1e-12 * elements.energy(0, places(f)));
  }
}

/// Two materials side by side, stretched alike: each keeps its stress up to the border.
TEST(StressRecovery, DoesNotSmearOverABorderOfMaterials) {
  constexpr Vec3 size{0.4, 0.4, 0.2};
  const Bodies bodies = single_body(box_mesh({4, 4, 2}, size));
  const Material soft{.young_modulus = 1e4, .poisson_ratio = 0.0};
  const Material stiff{.young_modulus = 1e6, .poisson_ratio = 0.0};
  std::vector<Index> of_tet;
  for (const Tet& t : bodies.tets()) {
    double y = 0.0;
    for (const Index p : t) y += 0.25 * at(bodies.points_rest(), p).y;
    of_tet.push_back(y < 0.5 * size.y ? 0 : 1);
  }
  const Materials materials({soft, stiff}, of_tet);
  const Elements elements(bodies, materials, std::vector<std::uint8_t>{0});
  constexpr double stretch = 1e-3;
  const auto positions = mapped(bodies, [](const Vec3& p) { return Vec3{p.x * (1.0 + stretch), p.y, p.z}; });
  const parallel::Threads threads(2);
  const TissueState tets = tissue_of_tets(threads, bodies, elements, positions);
  const TissueState points = tissue_of_points(threads, bodies, elements, materials, tets);
  std::size_t at_border = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double y = bodies.points_rest()[p].y;
    const double low = (1.0 + stretch) * stretch * soft.young_modulus / (1.0 + stretch);
    const double high = 100.0 * low;
    const double found = points.stress[p].xx;
    if (std::abs(y - 0.5 * size.y) < 1e-9) {
      ++at_border;
      EXPECT_TRUE(std::abs(found - low) < 1e-9 * high || std::abs(found - high) < 1e-9 * high) << found;
    } else {
      EXPECT_NEAR(found, y < 0.5 * size.y ? low : high, 1e-9 * high);
    }
  }
  EXPECT_EQ(at_border, 15U);
}

TEST(StressRows, OfRigidBodiesAreThoseOfRest) {
  Bodies bodies;
  bodies.add("rock", unit_tet_mesh());
  bodies.add("tissue", unit_tet_mesh());
  const Materials materials{rubber, rubber};
  const Elements elements(bodies, materials, std::vector<std::uint8_t>{1, 0});
  const auto positions = mapped(bodies, [](const Vec3& p) { return Vec3{1.1 * p.x, p.y, p.z}; });
  const TissueState tets = tissue_of_tets(parallel::Threads(1), bodies, elements, positions);
  EXPECT_EQ(tets.stress[0], SymmetricTensor{});
  EXPECT_EQ(tets.deformation_gradient[0], identity().values);
  EXPECT_EQ(tets.volume_ratio[0], 1.0);
  EXPECT_GT(tets.stress[1].xx, 1e3);
  const TissueState points = tissue_of_points(parallel::Threads(1), bodies, elements, materials, tets);
  EXPECT_EQ(points.stress[0], SymmetricTensor{});
  EXPECT_GT(points.stress[4].xx, 1e3);
}

}  // namespace
}  // namespace palpate::fem::test
