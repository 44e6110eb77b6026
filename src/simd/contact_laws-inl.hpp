// The loops of contact_laws.hpp, compiled once for each target. Lanes are written out and have no branches,
// so every compiler vectorises the loops and keeps the order of sums. No include guard, because it is
// included once per target.
#include <array>
#include <cmath>

using Lanes = std::array<double, law_lanes>;

/// A group of contacts at given velocities.
struct LawGroup {
  const double* row(LawRow which) const { return values + law_lanes * static_cast<std::size_t>(which); }

  LawGroup(const ContactLawRows& laws, const Vec3* u, std::size_t first)
      : values(laws.values + law_values / law_lanes * first) {
    const double* push = row(LawRow::push);
    const double* r = row(LawRow::resistance);
    const double* nx = row(LawRow::direction_x);
    const double* ny = row(LawRow::direction_y);
    const double* nz = row(LawRow::direction_z);
    const double* px = row(LawRow::pull_x);
    const double* py = row(LawRow::pull_y);
    const double* pz = row(LawRow::pull_z);
    Lanes ux;
    Lanes uy;
    Lanes uz;
    for (std::size_t k = 0; k < law_lanes; ++k) {
      ux[k] = u[first + k].x;
      uy[k] = u[first + k].y;
      uz[k] = u[first + k].z;
    }
    for (std::size_t k = 0; k < law_lanes; ++k) {
      const double along = ux[k] * nx[k] + uy[k] * ny[k] + uz[k] * nz[k];
      const double pushed = push[k] - r[k] * along;
      normal[k] = pushed > 0.0 ? pushed : 0.0;
      x[k] = -px[k] - r[k] * (ux[k] - along * nx[k]);
      y[k] = -py[k] - r[k] * (uy[k] - along * ny[k]);
      z[k] = -pz[k] - r[k] * (uz[k] - along * nz[k]);
    }
    for (std::size_t k = 0; k < law_lanes; ++k) size[k] = std::sqrt(x[k] * x[k] + y[k] * y[k] + z[k] * z[k]);
    for (std::size_t k = 0; k < law_lanes; ++k)
      bound[k] = laws.bounds == nullptr ? laws.friction * normal[k] : laws.bounds[first + k];
  }

  const double* values;
  Lanes normal;
  Lanes x;  ///< tangential force of spring and damper: x component
  Lanes y;
  Lanes z;
  Lanes size;  ///< length of (x, y, z)
  Lanes bound;
};

inline void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f,
                           std::size_t begin, std::size_t end) {
  for (std::size_t first = begin; first < end; first += law_lanes) {
    const LawGroup g(laws, u, first);
    const double* nx = g.row(LawRow::direction_x);
    const double* ny = g.row(LawRow::direction_y);
    const double* nz = g.row(LawRow::direction_z);
    Lanes scale;
    for (std::size_t k = 0; k < law_lanes; ++k) {
      const double sliding = g.bound[k] / g.size[k];
      scale[k] = g.size[k] > g.bound[k] ? sliding : 1.0;
    }
    for (std::size_t k = 0; k < law_lanes; ++k) {
      f[first + k] = {g.normal[k] * nx[k] + scale[k] * g.x[k] - base[first + k].x,
                      g.normal[k] * ny[k] + scale[k] * g.y[k] - base[first + k].y,
                      g.normal[k] * nz[k] + scale[k] * g.z[k] - base[first + k].z};
    }
  }
}

inline void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                                std::size_t end) {
  const bool coulomb = laws.bounds == nullptr;
  for (std::size_t first = begin; first < end; first += law_lanes) {
    const LawGroup g(laws, u, first);
    const double* r = g.row(LawRow::resistance);
    const double* nx = g.row(LawRow::direction_x);
    const double* ny = g.row(LawRow::direction_y);
    const double* nz = g.row(LawRow::direction_z);
    Lanes across;
    Lanes along;
    Lanes outer;   // components of p p^T
    Lanes couple;  // components of p n^T
    for (std::size_t k = 0; k < law_lanes; ++k) {
      const bool pushes = g.normal[k] > 0.0;
      const bool slides = g.size[k] > g.bound[k];
      const bool open = coulomb && !pushes;
      const double sliding = r[k] * g.bound[k] / g.size[k];
      const double a = slides ? sliding : r[k];
      const double square = a / (g.size[k] * g.size[k]);
      const double by_normal = laws.friction * r[k] / g.size[k];
      across[k] = open ? 0.0 : a;
      along[k] = (pushes ? r[k] : 0.0) - across[k];
      outer[k] = slides && !open ? square : 0.0;
      couple[k] = slides && !open && coulomb ? by_normal : 0.0;
    }
    std::array<Lanes, 9> m;
    const std::array<const double*, 3> n{nx, ny, nz};
    const std::array<const double*, 3> p{g.x.data(), g.y.data(), g.z.data()};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < law_lanes; ++k) {
          const double diagonal = i == j ? across[k] : 0.0;
          m[3 * i + j][k] = diagonal + along[k] * n[i][k] * n[j][k] - outer[k] * p[i][k] * p[j][k] +
                            couple[k] * p[i][k] * n[j][k];
        }
      }
    }
    for (std::size_t k = 0; k < law_lanes; ++k) {
      for (std::size_t e = 0; e < 9; ++e) h[9 * (first + k) + e] = m[e][k];
    }
  }
}
