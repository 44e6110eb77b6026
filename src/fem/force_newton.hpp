#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fem/contact_law.hpp"
#include "fem/matrix.hpp"

namespace palpate::fem {

/// A few contacts of bodies whose velocities depend linearly on the forces f_k of the contacts:
///
///   u_k = free_k + Y_k y,   y = h sum_k Y_k^T f_k.
struct CondensedContacts {
  std::span<const ContactLaw> laws;
  StepFriction friction{};
  std::span<const Vec3> free;    ///< relative velocities without contact forces, m/s
  std::span<const double> rows;  ///< (contacts x 3 x size) Y
  std::size_t size = 0;          ///< length of y

  /// start + Y_k y
  [[nodiscard]] Vec3 add_velocity(std::size_t contact, std::span<const double> y, Vec3 start) const;
  /// y += h Y_k^T f
  void add_impulse(std::size_t contact, const Vec3& f, std::span<double> y) const;
  /// y of these forces.
  void find_y(std::span<const Vec3> forces, std::span<double> y) const;
};

/// Finds the forces f_k of the laws at the velocities u_k that they cause, with the forces as unknowns.
///
/// A law is written as a projection: with v = u + f / R + (k / R) (slip - depth n) (R: resistance, k:
/// stiffness of the law), f is the law's force if f = P(f - rho v) for any rho > 0, where P projects onto the
/// cone of Coulomb: the normal part onto numbers >= 0, the tangential one onto the disc of its bound (Alart &
/// Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991)). With rho = R this is the law itself. Here rho is the
/// inverse response of the contact, so that the equation is well scaled although R may be 1e7 times that.
/// It is solved by semismooth Newton's method with a line search that is not monotone. It starts from the
/// given forces; if it fails, from no forces; if it fails again, from the given forces after a few sweeps of
/// projected Gauss-Seidel. There may be no solution, or several (Painleve's paradox).
///
/// Newton's method with the velocities as unknowns (ReducedStep) fails more often where R is far above the
/// inverse response: a step that is wrong by a little makes forces that are wrong by R times that.
class ForceNewton {
 public:
  /// Returns whether the equation holds up to rounding. Otherwise the forces are the last ones tried. Keeps
  /// its memory. O(contacts size^2 + size^3) an iteration.
  /// \param forces  (contacts) N
  bool solve(const CondensedContacts& problem, std::span<Vec3> forces);

 private:
  /// The law of a contact, written as a projection.
  struct Scaled {
    Vec3 normal{};
    double compliance = 0.0;  ///< 1 / R; 0: the law has no force
    double along = 0.0;       ///< rho of the normal part, N s/m
    double across = 0.0;      ///< rho of the tangential part
    Vec3 start{};             ///< v without forces

    struct Projection {
      Vec3 force{};
      double normal = 0.0;  ///< of the force
      Vec3 pull{};          ///< tangential part before it is limited
      double limit = 1.0;   ///< factor that limits it
    };
    [[nodiscard]] Projection project(const Vec3& f, const Vec3& v, double friction) const;
  };
  struct Iterate {
    std::vector<Vec3> forces;
    std::vector<Vec3> v;
  };
  void begin(const CondensedContacts& problem);
  bool iterate(const CondensedContacts& problem, int most, std::span<Vec3> forces);
  void sweep(const CondensedContacts& problem, std::span<Vec3> forces);
  void linearise(const CondensedContacts& problem);
  bool find_step(const CondensedContacts& problem);
  [[nodiscard]] double error(const CondensedContacts& problem, const Iterate& at) const;

  std::vector<Scaled> scaled_;  ///< of each contact
  std::vector<Vec3> given_;
  Iterate now_;
  Iterate trial_;
  Iterate step_;
  std::vector<Matrix3> stiffness_;  ///< of each contact: -df/du of the linearised equation
  std::vector<Vec3> shift_;     ///< of each contact: f at the current u by the linearised equation, minus f
  std::vector<double> matrix_;  ///< (size x size)
  std::vector<double> y_;
  double size_of_v_ = 0.0;  ///< of the velocities without forces
};

}  // namespace palpate::fem
