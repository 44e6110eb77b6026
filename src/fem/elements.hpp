#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/matrix.hpp"
#include "fem/plasticity.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// One value of each of N kinds per element, kind by kind.
template <std::size_t N>
using Columns = std::array<std::vector<double>, N>;

/// Linear corotational tets of all bodies that deform (Mueller & Gross, "Interactive Virtual Materials",
/// Graphics Interface 2004), numbered in the order of Bodies::tets() with the obstacles' left out.
///
/// With F = D_s D_m^-1 and R the rotation nearest to F, an element of volume V at rest has the energy
///   E = V (mu |F - R|^2 + lambda/2 tr^2(R^T F - I)).
/// Its force on corner i is f_i = -dE/dx_i = -V P g_i, with P = 2 mu (F - R) + lambda tr(R^T F - I) R and g_i
/// the gradient of corner i's shape function at rest: their warped force -R K (R^T x - x_rest). R makes
/// tr(R^T F) stationary, so that dR adds nothing. The stiffness blocks are theirs, K'_ij = R K_ij R^T with
///   K_ij = V (lambda g_i g_j^T + mu g_j g_i^T + mu (g_i . g_j) I),
/// minus the derivative of the force at fixed R: symmetric and positive semi-definite.
///
/// Where the material can yield, an element has a plastic strain p besides (plasticity.hpp), and its energy
/// is that of the elastic strain e = R^T F - I - p:
///   E = V (mu |e|^2 + lambda/2 tr^2(e)),  P = R (2 mu (e - [w]_x) + lambda tr(e) I),
/// the exact derivative at fixed p; w (plastic_twist) is the part of dR, which is no longer stationary. K'
/// stays as it is.
/// Deviations: R has det R = +1 for every F, so that inverted elements recover; F is built from
/// displacements, so that it is exactly I at rest.
class Elements {
 public:
  /// \param materials  checked by the caller
  /// \param obstacles  per body: 1 where the body's tets are left out
  /// Throws Error naming body and tet where rounding leaves a tet no positive volume or no finite inverse.
  /// O(n_tets).
  Elements(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> obstacles);

  [[nodiscard]] Index size() const { return static_cast<Index>(corners_.size()); }
  [[nodiscard]] std::span<const Tet> corners() const { return corners_; }  ///< (n_elements x 4) points
  [[nodiscard]] std::span<const Index> tet_of_element() const {
    return tets_;
  }  ///< (n_elements) tets of Bodies
  [[nodiscard]] std::span<const Index> body_of_element() const { return body_; }  ///< (n_elements)
  [[nodiscard]] std::span<const double> volumes_rest() const { return volume_; }  ///< (n_elements), m^3

  /// Rotations, forces and turned gradients of every element at these positions (n_points x 3, m).
  /// O(n_elements).
  void update(const parallel::Threads& threads, std::span<const Vec3> positions);

  /// Elastic force on corner 0..3 of an element as of the last update(), N; the four sum to zero to rounding.
  [[nodiscard]] Vec3 force(Index element, int corner) const;
  /// Adds factor times K'_ij of an element as of the last update() to a block, N/m. The block of (j, i) has
  /// exactly the transposed bits of (i, j).
  void add_stiffness(Index element, int i, int j, double factor, Matrix3& block) const;
  /// Elastic energy of an element at these positions, J; needs no update().
  [[nodiscard]] double energy(Index element, std::span<const Vec3> positions) const;
  /// Whether an element had no positive volume, or none that is a number, at the last update().
  [[nodiscard]] bool inverted(Index element) const { return at(inverted_, element) != 0; }

  /// Plastic strain of each element, in its own turned frame: (n_elements), or empty where no material
  /// yields; zero in elements that cannot.
  [[nodiscard]] std::span<const SymmetricMatrix3> plastic_strains() const { return plastic_strains_; }
  /// Sets it, from an array of the length of plastic_strains(); stays zero where the material cannot yield.
  void set_plastic_strains(std::span<const SymmetricMatrix3> strains);
  /// Plastic strains after a time step that ended at these positions, into `next` (length of
  /// plastic_strains()): plastic_flow() of each element, none where it is inverted, so that a shape without
  /// stress never is. O(n_elements).
  void flow(const parallel::Threads& threads, std::span<const Vec3> positions, double time_step,
            std::span<SymmetricMatrix3> next) const;

 private:
  void add_element(const Bodies& bodies, Index tet, Index body, const Material& material);
  void update_element(std::size_t element, std::span<const Vec3> positions);
  void add_plasticity(const Material& material);
  [[nodiscard]] bool yields(std::size_t element) const {
    return !plasticity_.empty() && plasticity_[element].yield.has_value();
  }
  [[nodiscard]] Matrix3 elastic_stretch(std::size_t element, const Matrix3& f, const Matrix3& rotation) const;
  [[nodiscard]] Vec3 gradient_rest(std::size_t element, int corner) const;
  [[nodiscard]] Matrix3 deformation_gradient(std::size_t element, std::span<const Vec3> positions) const;

  std::vector<Vec3> points_rest_;
  std::vector<Tet> corners_;
  std::vector<Index> tets_;
  std::vector<Index> body_;
  Columns<9> inverse_rest_;  ///< D_m^-1, row by row: row k is the gradient of corner k + 1
  std::vector<double> volume_;
  std::vector<double> mu_;
  std::vector<double> lambda_;
  Columns<12> gradients_;                          ///< R g_i, corner by corner
  Columns<12> forces_;                             ///< corner by corner
  std::vector<std::uint8_t> inverted_;             ///< (n_elements), as of the last update()
  std::vector<Plasticity> plasticity_;             ///< (n_elements), or empty where no material yields
  std::vector<SymmetricMatrix3> plastic_strains_;  ///< as plasticity_
};

}  // namespace palpate::fem
