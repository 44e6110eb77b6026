#include "fem/meshes.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/vector.hpp"

namespace palpate::fem::test {
namespace {

/// Corner numbers of a cell: bit 0 along x, bit 1 along y, bit 2 along z.
constexpr std::array<std::array<int, 4>, 5> even_cell{
    {{0, 1, 2, 4}, {3, 1, 7, 2}, {5, 1, 4, 7}, {6, 2, 7, 4}, {1, 2, 4, 7}}};
constexpr std::array<std::array<int, 4>, 5> odd_cell{
    {{1, 0, 5, 3}, {2, 0, 3, 6}, {4, 0, 6, 5}, {7, 3, 5, 6}, {0, 3, 5, 6}}};

}  // namespace

TetMesh box_mesh(const std::array<int, 3>& cells, const Vec3& size) {
  TetMesh mesh;
  const auto [nx, ny, nz] = cells;
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i)
        mesh.points.push_back({size.x * i / nx, size.y * j / ny, size.z * k / nz});
    }
  }
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (const auto& tet : (i + j + k) % 2 == 0 ? even_cell : odd_cell) {
          Tet corners{};
          for (std::size_t c = 0; c < 4; ++c) {
            const int bits = tet[c];
            corners[c] = (i + (bits & 1)) + (nx + 1) * ((j + (bits >> 1 & 1)) + (ny + 1) * (k + (bits >> 2)));
          }
          mesh.tets.push_back(corners);
        }
      }
    }
  }
  return mesh;
}

TetMesh irregular_box_mesh(const std::array<int, 3>& cells, const Vec3& size, double fraction) {
  TetMesh mesh = box_mesh(cells, size);
  std::mt19937_64 random(11);
  for (Vec3& p : mesh.points) {
    const Vec3 move = random_vector(random, fraction);
    if (!on_surface(p, size)) {
      p += Vec3{move.x * size.x / cells[0], move.y * size.y / cells[1], move.z * size.z / cells[2]};
    }
  }
  return mesh;
}

TetMesh unit_tet_mesh(double size) {
  return {{{0.0, 0.0, 0.0}, {size, 0.0, 0.0}, {0.0, size, 0.0}, {0.0, 0.0, size}}, {{0, 1, 2, 3}}};
}

std::vector<std::uint8_t> select(const Bodies& bodies, const std::function<bool(const Vec3&)>& where) {
  std::vector<std::uint8_t> chosen;
  for (const Vec3& p : bodies.points_rest()) chosen.push_back(where(p) ? 1 : 0);
  return chosen;
}

bool on_surface(const Vec3& p, const Vec3& size) {
  return p.x == 0.0 || p.y == 0.0 || p.z == 0.0 || p.x == size.x || p.y == size.y || p.z == size.z;
}

std::vector<Vec3> mapped(const Bodies& bodies, const std::function<Vec3(const Vec3&)>& map) {
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  std::transform(positions.begin(), positions.end(), positions.begin(), map);
  return positions;
}

std::vector<Vec3> noisy(const Bodies& bodies, double amplitude, unsigned seed) {
  std::mt19937_64 random(seed);
  return mapped(bodies, [&](const Vec3& p) { return p + random_vector(random, amplitude); });
}

std::vector<Vec3> random_vectors(std::size_t count, double amplitude, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<Vec3> values(count);
  for (Vec3& v : values) v = random_vector(random, amplitude);
  return values;
}

Vec3 random_vector(std::mt19937_64& random, double amplitude) {
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  const double x = uniform(random);
  const double y = uniform(random);
  const double z = uniform(random);
  return {x, y, z};
}

Matrix3 random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::Quaterniond q;
  for (int i = 0; i < 4; ++i) q.coeffs()[i] = normal(random);
  return from_eigen(q.normalized().toRotationMatrix());
}

Eigen::Matrix3d to_eigen(const Matrix3& a) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m(i, j) = a(i, j);
  }
  return m;
}

Eigen::Matrix3d to_eigen(const SymmetricMatrix3& a) {
  Eigen::Matrix3d m;
  m << a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz;
  return m;
}

Eigen::Vector3d to_eigen(const Vec3& a) {
  return {a.x, a.y, a.z};
}

Eigen::VectorXd to_eigen(std::span<const Vec3> a) {
  Eigen::VectorXd v(3 * static_cast<Eigen::Index>(a.size()));
  for (std::size_t i = 0; i < a.size(); ++i) v.segment<3>(3 * static_cast<Eigen::Index>(i)) = to_eigen(a[i]);
  return v;
}

Matrix3 from_eigen(const Eigen::Matrix3d& a) {
  Matrix3 m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m(i, j) = a(i, j);
  }
  return m;
}

double largest(std::span<const Vec3> values) {
  double most = 0.0;
  // Not std::max alone: a NaN must not look small.
  for (const Vec3& v : values) most = length(v) <= most ? most : length(v);
  return most;
}

double largest_distance(std::span<const Vec3> a, std::span<const Vec3> b) {
  std::vector<Vec3> difference(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
  return largest(difference);
}

Vec3 total(std::span<const Vec3> values) {
  Vec3 sum;
  for (const Vec3& v : values) sum += v;
  return sum;
}

std::vector<simd::Padded3> padded(std::span<const Vec3> a) {
  std::vector<simd::Padded3> rows;
  for (const Vec3& v : a) rows.push_back({v.x, v.y, v.z, 0.0});
  return rows;
}

std::vector<Vec3> unpadded(std::span<const simd::Padded3> a) {
  std::vector<Vec3> values;
  for (const simd::Padded3& v : a) values.push_back({v.x, v.y, v.z});
  return values;
}

std::vector<Vec3> point_forces(const Elements& elements) {
  return unpadded(elements.point_forces());
}

Dynamics Scene::dynamics(const Bodies& bodies) const {
  const std::size_t points = bodies.points_rest().size();
  const auto count = static_cast<std::size_t>(bodies.body_count());
  return Dynamics(bodies, std::vector<Material>(count, material),
                  fixed.empty() ? std::vector<std::uint8_t>(points, 0) : fixed,
                  std::vector<std::uint8_t>(count, 0), parallel::Threads(threads));
}

void settle(Dynamics& dynamics, std::span<const Vec3> forces, int steps, double tolerance,
            int max_iterations) {
  const std::vector<Vec3> zero(dynamics.positions().size());
  for (int i = 0; i < steps; ++i) {
    dynamics.step(1e4, {}, forces, {}, tolerance, max_iterations);
    dynamics.set_velocities(zero);
    dynamics.set_velocity_changes(zero);
  }
}

std::vector<Vec3> rotation_of(std::span<const double> masses, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities) {
  double mass = 0.0;
  Vec3 center;
  Vec3 drift;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    mass += masses[i];
    center += masses[i] * positions[i];
    drift += masses[i] * velocities[i];
  }
  center = (1.0 / mass) * center;
  drift = (1.0 / mass) * drift;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const Vec3 arm = positions[i] - center;
    const Vec3 own = masses[i] * cross(arm, velocities[i] - drift);
    const Eigen::Vector3d r(arm.x, arm.y, arm.z);
    momentum += Eigen::Vector3d(own.x, own.y, own.z);
    inertia += masses[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d omega = inertia.ldlt().solve(momentum);
  std::vector<Vec3> rotation;
  for (const Vec3& p : positions)
    rotation.push_back(cross(Vec3{omega.x(), omega.y(), omega.z()}, p - center));
  return rotation;
}

Eigen::MatrixXd dense_stiffness(const Elements& elements, std::size_t point_count) {
  const auto n = 3 * static_cast<Eigen::Index>(point_count);
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  for (Index e = 0; e < elements.size(); ++e) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        Matrix3 block;
        elements.add_stiffness(e, i, j, block);
        const Tet& corners = at(elements.corners(), e);
        k.block<3, 3>(3 * at(corners, i), 3 * at(corners, j)) += to_eigen(block);
      }
    }
  }
  return k;
}

Vec3 momentum(const Dynamics& dynamics) {
  Vec3 sum;
  for (std::size_t i = 0; i < dynamics.positions().size(); ++i) {
    sum += dynamics.point_masses()[i] * dynamics.velocities()[i];
  }
  return sum;
}

std::vector<float> random_floats(std::size_t count, unsigned seed, float low) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> uniform(low, 1.0F);
  std::vector<float> values(count);
  for (float& value : values) value = uniform(random);
  return values;
}

double total_energy(const Elements& elements, std::span<const Vec3> positions) {
  double sum = 0.0;
  for (Index e = 0; e < elements.size(); ++e) sum += elements.energy(e, positions);
  return sum;
}

double zero_of(const std::function<double(double)>& f, double low, double high) {
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    (f(middle) > 0.0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

int inverted_tets(const Bodies& bodies, std::span<const Vec3> positions) {
  return static_cast<int>(std::ranges::count_if(bodies.tets(), [&](const Tet& t) {
    const Vec3& a = at(positions, t[0]);
    return !(dot(at(positions, t[1]) - a, cross(at(positions, t[2]) - a, at(positions, t[3]) - a)) > 0.0);
  }));
}

}  // namespace palpate::fem::test
