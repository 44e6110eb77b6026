#pragma once

#include <cstddef>

#include <palpate/types.hpp>

/// Forces of contacts (fem::ContactLaw) and their derivatives, eight contacts at a time. With Coulomb's law
/// the forces have the bits of fem::contact_force(). If the friction bounds are given instead, the forces of
/// all contacts are the derivative of a convex function of the velocities, which a line search can use.
namespace palpate::simd {

/// Contacts per group. Lists have room for whole groups. Laws after the last contact are zero.
inline constexpr std::size_t law_lanes = 8;
/// Numbers of a group: rows of law_lanes.
enum class LawRow : std::size_t {
  push,
  resistance,
  direction_x,
  direction_y,
  direction_z,
  pull_x,
  pull_y,
  pull_z
};
inline constexpr std::size_t law_values = 8 * law_lanes;

/// Parameters of the contact forces.
struct ContactLawRows {
  /// Groups of law_values. For each contact: stiffness times depth, N; resistance R, N s/m; direction;
  /// stiffness times slip, N.
  const double* values;
  double friction;       ///< Coulomb's coefficient
  const double* bounds;  ///< friction bound of each contact, N; null: the coefficient times the normal force
};

/// f_k: the force at the relative velocity u_k, minus base_k, for contacts [begin, end), which are whole
/// groups.
void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f, std::size_t begin,
                    std::size_t end);
/// h_k = -df/du at u_k, N s/m: nine numbers for each contact, row by row. With s = R mu f_n / |p|, n the
/// direction and t = p / |p|, a sliding contact has the unsymmetric R n n^T + s (I - n n^T - t t^T) + mu R t
/// n^T. If friction bounds are given, the last term is absent, and h_k is symmetric positive semi-definite.
void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                         std::size_t end);

/// The kernels above, compiled for the simplest target.
namespace scalar {
void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f, std::size_t begin,
                    std::size_t end);
void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                         std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd
