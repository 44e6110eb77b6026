// Geometric stiffness of corotational elements (tense_elements.hpp).
#include <array>
#include <cmath>
#include <cstddef>

#include "fem/elements.hpp"
#include "fem/padded_vectors.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {

/// Appends an element whose other results are set, if it is tense; or adds to its tangent blocks.
/// \param forces  on its corners
void Elements::add_tension(std::size_t element, const double* forces,
                           std::vector<TenseElements::Tense>& tense) {
  if (!tense_.may_be_tense(element, energy_[element]) || !is_corotational(element) || inverted_[element] != 0)
    return;
  // With a_i = s R g_i and forces -V P g_i, S a_i = P R^T a_i is the force times -s / V.
  const auto force = [&](std::size_t corner) {
    return Vec3{forces[4 * corner], forces[4 * corner + 1], forces[4 * corner + 2]};
  };
  const auto e = static_cast<Index>(element);
  const Matrix3 to_corners = inverse(from_rows(gradient(e, 1), gradient(e, 2), gradient(e, 3)));
  const Matrix3 forces_by_axis = transposed(from_rows(force(1), force(2), force(3)));
  const Matrix3 stress = times_transposed(to_corners, forces_by_axis);  // transposed; without the factor
  const double scale = std::sqrt(factor_[element] * stiffness_[element]) / volume_[element];
  const std::size_t before = tense.size();
  tense_.add_if_tense(element, -scale * symmetric_part(stress), energy_[element] / volume_[element], tense);
  if (tense.size() == before || !has_tangent_blocks(element)) return;
  add_tension_blocks(element, tense.back().q);
  tense.pop_back();
}

void Elements::add_tension_blocks(std::size_t element, const SymmetricMatrix3& q) {
  const auto e = static_cast<Index>(element);
  float* const blocks = &blocks_[simd::block_stride * (element - static_cast<std::size_t>(tangent_begin_))];
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const Matrix3 block = geometric_block(q, gradient(e, i), gradient(e, j));
      for (std::size_t k = 0; k < 9; ++k)
        blocks[block_place(i, j) + k] += static_cast<float>(block.values[k]);
    }
  }
}

/// Adds the products of the geometric stiffness with the vectors at the corners of an element.
void Elements::multiply_tense(const TenseElements::Tense& tense, const std::array<Vec3, 4>& vectors,
                              std::array<Vec3, 4>& products) const {
  Vec3 sum;
  for (int i = 0; i < 4; ++i) sum += cross(gradient(tense.element, i), at(vectors, i));
  const Vec3 turned = tense.q * sum;
  for (int i = 0; i < 4; ++i) at(products, i) += cross(turned, gradient(tense.element, i));
}

/// Adds them for elements [begin, end), by corner.
void Elements::add_tense_products(std::size_t begin, std::size_t end, std::span<const simd::Padded3> vectors,
                                  CornerSums::Values& products) const {
  for (const TenseElements::Tense& tense : tense_.among(begin, end)) {
    const Tet& corners = at(corners_, tense.element);
    std::array<Vec3, 4> of_corners;
    for (std::size_t k = 0; k < 4; ++k) of_corners[k] = unpadded(at(vectors, corners[k]));
    std::array<Vec3, 4> own{};
    multiply_tense(tense, of_corners, own);
    double* const place = &products[16 * (static_cast<std::size_t>(tense.element) - begin)];
    for (std::size_t k = 0; k < 4; ++k) {
      place[4 * k] += own[k].x;
      place[4 * k + 1] += own[k].y;
      place[4 * k + 2] += own[k].z;
    }
  }
}

}  // namespace palpate::fem
