// Manufactured solutions: choose a displacement, and differentiate the law in long double for its body force.
// The error of the solution falls with the square of the cell size.
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "fem/laws.hpp"
#include "fem/meshes.hpp"
#include "support/meshes.hpp"

namespace palpate::fem::test {
namespace {

using Vector = Eigen::Matrix<Real, 3, 1>;

/// Deformed position of a point of the unit cube: strains of some 20 %, and a rotation of the whole.
Vector place(const Vector& p) {
  constexpr Real a = 0.1L;
  const Vector moved(p.x() + a * (std::sin(2 * p.y()) + p.x() * p.z()),
                     p.y() + a * (std::cos(2 * p.x() + p.z())),
                     p.z() + a * (p.x() * p.x() * p.y() - std::sin(p.z() + p.x())));
  const Real c = std::cos(0.7L);
  const Real s = std::sin(0.7L);
  return {c * moved.x() - s * moved.y(), s * moved.x() + c * moved.y(), moved.z()};
}

template <class Function>
auto difference(Function&& f, const Vector& p, int axis, Real d) {
  const auto at = [&](int n) {
    Vector q = p;
    q[axis] += static_cast<Real>(n) * d;
    return f(q);
  };
  return ((8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * d)).eval();
}

Matrix gradient(const Vector& p) {
  Matrix f;
  for (int k = 0; k < 3; ++k) f.col(k) = difference(place, p, k, 1e-4L);
  return f;
}

/// Force per volume at rest: minus the divergence of P.
Vector body_force(const Material& m, const Vector& p) {
  Vector sum = Vector::Zero();
  for (int k = 0; k < 3; ++k)
    sum -= difference([&](const Vector& q) -> Vector { return stress(m, gradient(q)).col(k); }, p, k, 1e-3L);
  return sum;
}

Vector to_long(const Vec3& p) {
  return {p.x, p.y, p.z};
}

Vec3 placed(const Vec3& p) {
  const Vector q = place(to_long(p));
  return {static_cast<double>(q.x()), static_cast<double>(q.y()), static_cast<double>(q.z())};
}

/// Root of the mean square of the distance from where inner points should be.
double error_of(const Material& m, int n) {
  const Bodies bodies = single_body(palpate::test::box_mesh({n, n, n}, {0, 0, 0}, {1, 1, 1}));
  std::vector<Vec3> forces(bodies.points_rest().size());
  for (const Tet& tet : bodies.tets()) {
    std::array<Vec3, 4> p;
    for (std::size_t k = 0; k < 4; ++k) p[k] = at(bodies.points_rest(), tet[k]);
    const double volume = dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])) / 6.0;
    const Vector b = body_force(m, to_long(0.25 * (p[0] + p[1] + p[2] + p[3])));
    const Vec3 quarter{static_cast<double>(b.x()), static_cast<double>(b.y()), static_cast<double>(b.z())};
    for (const Index corner : tet) at(forces, corner) += (0.25 * volume) * quarter;
  }
  const auto held = select(bodies, [](const Vec3& p) { return on_surface(p, {1, 1, 1}); });
  Dynamics dynamics = Scene{m, held, 1}.dynamics(bodies);
  dynamics.set_positions(mapped(bodies, placed));
  settle(dynamics, forces, m.model == MaterialModel::corotational ? 12 : 5, 1e-10, 4000);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (held[i] != 0) continue;
    sum += squared_length(dynamics.positions()[i] - placed(bodies.points_rest()[i]));
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(ManufacturedOrder, DisplacementsAreOfSecondOrderForEachLaw) {
  for (const MaterialModel model :
       {MaterialModel::corotational, MaterialModel::stable_neo_hookean, MaterialModel::mooney_rivlin}) {
    for (const double nu : {0.3, 0.45}) {
      const Material m{.young_modulus = 2e4, .poisson_ratio = nu, .density = 1.0, .model = model};
      const double coarse = error_of(m, 5);
      const double fine = error_of(m, 10);
      const double order = std::log2(coarse / fine);
      std::printf("%s, nu %.2f: errors %.2e, %.2e, order %.2f\n",
                  std::string(material_model_names[static_cast<std::size_t>(model)]).c_str(), nu, coarse,
                  fine, order);
      EXPECT_GT(order, 1.7);
      EXPECT_LT(order, 2.5);
    }
  }
}

}  // namespace
}  // namespace palpate::fem::test
