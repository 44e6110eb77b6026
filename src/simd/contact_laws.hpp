#pragma once

#include <cstddef>

#include <palpate/types.hpp>

/// Forces of contacts and their derivatives, eight contacts at a time: fem::contact_force(),
/// force_with_bound(), derivative() and derivative_with_bound(), to the same bits.
namespace palpate::simd {

/// Contacts go in groups of so many; lists have room for whole groups, laws beyond the last are zero.
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

/// What the forces of contacts are made of.
struct ContactLawRows {
  /// Groups of law_values: stiffness times depth, N; resistance, N s/m; direction; stiffness times slip, N.
  const double* values;
  double friction;       ///< Coulomb's coefficient
  const double* bounds;  ///< of friction, N, by contact; null: the coefficient times the normal force
};

/// f_k = force at the relative velocity u_k less base_k, of contacts [begin, end): whole groups.
void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f, std::size_t begin,
                    std::size_t end);
/// h_k = -df/du at u_k, nine numbers a contact, row by row.
void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                         std::size_t end);

/// The same for the plainest target.
namespace scalar {
void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f, std::size_t begin,
                    std::size_t end);
void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                         std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd
