#include "fem/harmonic_field.hpp"

#include "geometry/vector.hpp"
#include "mesh/faces.hpp"

namespace palpate::fem {
namespace {

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Product a b where the point is free and belongs to a tet; else 0.
void precondition(std::span<const double> inverse, std::span<const double> residual, std::vector<double>& z) {
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = inverse[i] * residual[i];
}

}  // namespace

ScalarTets::ScalarTets(std::span<const Vec3> points, std::span<const Tet> tets, Index first_point) {
  for (const Tet& tet : tets) {
    Tet own = tet;
    for (Index& corner : own) corner -= first_point;
    const auto corner = [&](std::size_t i) { return at(points, own[i]); };
    const double six_volumes =
        dot(corner(1) - corner(0), cross(corner(2) - corner(0), corner(3) - corner(0)));
    std::array<Vec3, 4> gradients;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& [a, b, c] = outward_face[i];
      gradients[i] = (-1.0 / six_volumes) * cross(corner(b) - corner(a), corner(c) - corner(a));
    }
    tets_.push_back(own);
    shape_gradients_.push_back(gradients);
    volumes_.push_back(six_volumes / 6.0);
  }
}

/// Uses differences to the value at the first corner, so that the gradient of a constant field is exactly
/// zero.
Vec3 ScalarTets::gradient(std::size_t tet, std::span<const double> field) const {
  const Tet& corner = tets_[tet];
  Vec3 sum{};
  for (std::size_t i = 1; i < 4; ++i)
    sum += (at(field, corner[i]) - at(field, corner[0])) * shape_gradients_[tet][i];
  return sum;
}

void ScalarTets::multiply(std::span<const double> field, std::vector<double>& result) const {
  result.assign(field.size(), 0.0);
  for (std::size_t tet = 0; tet < tets_.size(); ++tet) {
    const Vec3 flow = volumes_[tet] * gradient(tet, field);
    for (std::size_t i = 0; i < 4; ++i) at(result, tets_[tet][i]) += dot(flow, shape_gradients_[tet][i]);
  }
}

std::vector<double> ScalarTets::diagonal(std::size_t n_points) const {
  std::vector<double> result(n_points, 0.0);
  for (std::size_t tet = 0; tet < tets_.size(); ++tet) {
    for (std::size_t i = 0; i < 4; ++i)
      at(result, tets_[tet][i]) += volumes_[tet] * squared_length(shape_gradients_[tet][i]);
  }
  return result;
}

void solve_laplace(const ScalarTets& tets, std::span<const std::uint8_t> held, std::vector<double>& field) {
  constexpr double tolerance = 1e-14;
  const std::size_t n = field.size();
  std::vector<double> inverse = tets.diagonal(n);
  for (std::size_t i = 0; i < n; ++i) inverse[i] = held[i] != 0 || inverse[i] <= 0.0 ? 0.0 : 1.0 / inverse[i];
  std::vector<double> residual;
  std::vector<double> z(n);
  tets.multiply(field, residual);
  for (double& value : residual) value = -value;
  precondition(inverse, residual, z);
  std::vector<double> direction = z;
  std::vector<double> image;
  double now = dot(residual, z);
  const double end = tolerance * tolerance * now;
  for (std::size_t iteration = 0; now > end && iteration < 10 * n; ++iteration) {
    tets.multiply(direction, image);
    const double step = now / dot(direction, image);
    for (std::size_t i = 0; i < n; ++i) {
      field[i] += step * direction[i];
      residual[i] -= step * image[i];
    }
    precondition(inverse, residual, z);
    const double before = now;
    now = dot(residual, z);
    for (std::size_t i = 0; i < n; ++i) direction[i] = z[i] + now / before * direction[i];
  }
}

}  // namespace palpate::fem
