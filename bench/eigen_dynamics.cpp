#include "eigen_dynamics.hpp"

#include <Eigen/Dense>

#include "geometry/vector.hpp"

namespace palpate::bench {
namespace {

Eigen::Vector3d eigen(const Vec3& a) {
  return {a.x, a.y, a.z};
}

/// Higham's scaled iteration; SVD where the element is inverted or nearly flat.
Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& f) {
  if (f.determinant() < 0.01) {
    const Eigen::JacobiSVD<Eigen::Matrix3d, Eigen::FullPivHouseholderQRPreconditioner> svd(
        f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) *= -1.0;
    return u * svd.matrixV().transpose();
  }
  Eigen::Matrix3d r = f;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Matrix3d inverse = r.inverse();
    const double g = std::sqrt(inverse.norm() / r.norm());
    const Eigen::Matrix3d next = 0.5 * (g * r + inverse.transpose() / g);
    const double change = (next - r).squaredNorm();
    r = next;
    if (change < 1e-16) break;
  }
  return r;
}

}  // namespace

EigenDynamics::EigenDynamics(const Bodies& bodies, const Material& material,
                             std::span<const std::uint8_t> free, std::span<const double> masses,
                             double time_step)
    : rest_(bodies.points_rest().begin(), bodies.points_rest().end()),
      place_(free.size(), -1),
      masses_(masses.begin(), masses.end()),
      time_step_(time_step),
      factor_(time_step * (material.stiffness_damping + time_step)),
      mu_(material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))),
      lambda_(2.0 * mu_ * material.poisson_ratio / (1.0 - 2.0 * material.poisson_ratio)) {
  int count = 0;
  for (std::size_t p = 0; p < free.size(); ++p) {
    if (free[p] != 0) place_[p] = count++;
  }
  std::vector<Eigen::Triplet<double>> pattern;
  for (const Tet& tet : bodies.tets()) {
    for (const Index a : tet) {
      for (const Index b : tet) {
        if (at(place_, a) < 0 || at(place_, b) < 0) continue;
        for (int i = 0; i < 9; ++i)
          pattern.emplace_back(3 * at(place_, a) + i / 3, 3 * at(place_, b) + i % 3, 0.0);
      }
    }
  }
  matrix_.resize(3 * count, 3 * count);
  matrix_.setFromTriplets(pattern.begin(), pattern.end());
  right_side_.resize(3 * count);
  const auto slot = [&](int row, int column) {
    return static_cast<int>(&matrix_.coeffRef(row, column) - matrix_.valuePtr());
  };
  for (int row = 0; row < 3 * count; ++row) diagonal_slots_.push_back(slot(row, row));
  for (const Tet& tet : bodies.tets()) {
    Element element;
    element.corners = tet;
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = eigen(at(rest_, at(tet, k + 1))) - eigen(at(rest_, tet[0]));
    element.inverse_rest = edges.inverse();
    element.volume = edges.determinant() / 6.0;
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        const int pa = at(place_, at(tet, a));
        const int pb = at(place_, at(tet, b));
        for (int i = 0; i < 3; ++i)
          at(element.slots, 12 * a + 3 * b + i) = pa < 0 || pb < 0 ? -1 : slot(3 * pa + i, 3 * pb);
      }
    }
    elements_.push_back(element);
  }
}

Eigen::Matrix3d EigenDynamics::deformation(const Element& element, std::span<const Vec3> positions) const {
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) =
        eigen(at(positions, at(element.corners, k + 1))) - eigen(at(positions, element.corners[0]));
  return edges * element.inverse_rest;
}

void EigenDynamics::update(std::span<const Vec3> positions, const Vec3& gravity) {
  double* values = matrix_.valuePtr();
  std::fill(values, values + matrix_.nonZeros(), 0.0);
  for (std::size_t p = 0; p < masses_.size(); ++p) {
    if (place_[p] < 0) continue;
    right_side_.segment<3>(3 * place_[p]) = time_step_ * masses_[p] * eigen(gravity);
    for (int i = 0; i < 3; ++i) values[at(diagonal_slots_, 3 * place_[p] + i)] += masses_[p];
  }
  for (const Element& element : elements_) {
    const Eigen::Matrix3d f = deformation(element, positions);
    const Eigen::Matrix3d r = rotation_of(f);
    const Eigen::Matrix3d stretch = f - r;
    const double trace = r.cwiseProduct(stretch).sum();
    const Eigen::Matrix3d stress = -element.volume * (2.0 * mu_ * stretch + lambda_ * trace * r);
    Eigen::Matrix<double, 3, 4> rest;
    rest.rightCols<3>() = element.inverse_rest.transpose();
    rest.col(0) = -rest.rightCols<3>().rowwise().sum();
    const Eigen::Matrix<double, 3, 4> forces = stress * rest;
    const Eigen::Matrix<double, 3, 4> g = r * rest;
    const double mu = factor_ * element.volume * mu_;
    const double lambda = factor_ * element.volume * lambda_;
    for (int a = 0; a < 4; ++a) {
      const int pa = at(place_, at(element.corners, a));
      if (pa < 0) continue;
      right_side_.segment<3>(3 * pa) += time_step_ * forces.col(a);
      for (int b = 0; b < 4; ++b) {
        if (at(element.slots, 12 * a + 3 * b) < 0) continue;
        Eigen::Matrix3d block =
            lambda * g.col(a) * g.col(b).transpose() + mu * g.col(b) * g.col(a).transpose();
        block.diagonal().array() += mu * g.col(a).dot(g.col(b));
        for (int i = 0; i < 3; ++i)
          Eigen::Map<Eigen::RowVector3d>(values + at(element.slots, 12 * a + 3 * b + i)) += block.row(i);
      }
    }
  }
}

}  // namespace palpate::bench
