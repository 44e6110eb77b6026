#include "fem/tissue.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "fem/stress.hpp"
#include "fem/symmetric_eigen.hpp"
#include "simd/stress_pass.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t tissue_grain = 128;
constexpr double no_stress = std::numeric_limits<double>::quiet_NaN();

/// Rows of tets without strain, without what find_invariants() adds.
TissueState rows_at_rest(std::size_t count, TissueState state) {
  state.deformation_gradient.assign(count, identity().values);
  for (auto* tensors : {&state.strain, &state.stress, &state.plastic_strain}) tensors->assign(count, {});
  state.energy_density.resize(count);
  state.volume_ratio.assign(count, 1.0);
  return state;
}

/// Computes the results that follow from the stress, for a range of rows.
void find_invariants(const parallel::Threads& threads, TissueState& state) {
  state.von_mises.resize(state.size());
  state.pressure.resize(state.size());
  state.principal_stress.assign(state.size(), {});  // assign() writes rows faster than resize()
  state.principal_directions.assign(state.size(), {});
  parallel::for_chunks(
      threads, state.size(), tissue_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t row = begin; row < end; ++row) {
          const SymmetricTensor& stress = state.stress[row];
          state.von_mises[row] = von_mises(to_matrix(stress));
          state.pressure[row] = (stress.xx + stress.yy + stress.zz) / -3.0;
        }
        const auto part = [&](auto& rows) { return std::span(rows).subspan(begin, end - begin); };
        const std::size_t done = simd::symmetric_eigen(part(state.stress), part(state.principal_stress),
                                                       part(state.principal_directions));
        for (std::size_t row = begin + done; row < end; ++row) {
          const SymmetricEigen eigen = symmetric_eigen(to_matrix(state.stress[row]));
          state.principal_stress[row] = eigen.values;
          state.principal_directions[row] = eigen.vectors;
        }
      });
}

/// Writes the row of element `lane` of a group.
void put_row(const simd::GroupStress& found, std::size_t lane, TissueState& state, std::size_t row) {
  for (std::size_t k = 0; k < 9; ++k) state.deformation_gradient[row][k] = found.gradient[k][lane];
  const auto tensor = [&](const auto& columns) {
    return SymmetricTensor{columns[0][lane], columns[1][lane], columns[2][lane],
                           columns[3][lane], columns[4][lane], columns[5][lane]};
  };
  state.strain[row] = tensor(found.strain);
  state.stress[row] = tensor(found.stress);
  state.energy_density[row] = found.energy_density[lane];
  state.volume_ratio[row] = found.volume_ratio[lane];
}

/// Element of each tet; -1 for tets of rigid bodies.
std::vector<Index> elements_of_tets(const Bodies& bodies, const Elements& elements) {
  std::vector<Index> element(bodies.tets().size(), -1);
  const auto tets = elements.tet_of_element();
  for (std::size_t e = 0; e < tets.size(); ++e) at(element, tets[e]) = static_cast<Index>(e);
  return element;
}

/// The mean over some tets of a point, weighted by their volumes.
struct Mean {
  double volume = 0.0;
  double stressed_volume = 0.0;  ///< volume of the tets that have a stress
  SymmetricMatrix3 strain{};
  SymmetricMatrix3 stress{};
  SymmetricMatrix3 plastic_strain{};
  Tensor gradient{};
  double energy_density = 0.0;
  double volume_ratio = 0.0;

  void add(const TissueState& tets, std::size_t tet, double v) {
    volume += v;
    for (std::size_t k = 0; k < 9; ++k) gradient[k] += v * tets.deformation_gradient[tet][k];
    strain = strain + v * to_matrix(tets.strain[tet]);
    plastic_strain = plastic_strain + v * to_matrix(tets.plastic_strain[tet]);
    energy_density += v * tets.energy_density[tet];
    volume_ratio += v * tets.volume_ratio[tet];
    if (!(tets.volume_ratio[tet] > 0.0)) return;
    stressed_volume += v;
    stress = stress + v * to_matrix(tets.stress[tet]);
  }
  void put(TissueState& points, std::size_t row) const {
    const double scale = 1.0 / volume;
    for (std::size_t k = 0; k < 9; ++k) points.deformation_gradient[row][k] = scale * gradient[k];
    points.strain[row] = to_tensor(scale * strain);
    points.plastic_strain[row] = to_tensor(scale * plastic_strain);
    points.energy_density[row] = scale * energy_density;
    points.volume_ratio[row] = scale * volume_ratio;
    points.stress[row] = to_tensor((stressed_volume > 0.0 ? 1.0 / stressed_volume : no_stress) * stress);
  }
};

/// The tets around a point, for the mean at the point.
struct Around {
  const Bodies& bodies;
  const Elements& elements;
  const Materials& materials;
  std::vector<Index> element;  ///< of each tet

  [[nodiscard]] Index material(Index tet) const {
    return materials.of_tet.empty() ? bodies.body_of(at(bodies.tets(), tet)) : at(materials.of_tet, tet);
  }
  [[nodiscard]] double volume(Index tet) const { return at(elements.volumes_rest(), at(element, tet)); }
  /// The material with the most volume at a point, or -1.
  [[nodiscard]] Index material_at(Index point) const {
    const std::span<const Index> tets = bodies.point_tets()[point];
    if (tets.empty() || at(element, tets.front()) < 0) return -1;
    const auto same = [&](Index tet) { return material(tet) == material(tets.front()); };
    return std::ranges::all_of(tets, same) ? material(tets.front()) : material_with_most(tets);
  }
  [[nodiscard]] Index material_with_most(std::span<const Index> tets) const {
    Index best = -1;
    double most = 0.0;
    for (const Index tet : tets) {
      double sum = 0.0;
      for (const Index other : tets) {
        if (material(other) == material(tet)) sum += volume(other);
      }
      if (sum > most) {
        most = sum;
        best = material(tet);
      }
    }
    return best;
  }
};

}  // namespace

TissueState strain_of_tets(const parallel::Threads& threads, const Bodies& bodies, const Elements& elements,
                           std::span<const Vec3> positions, TissueState memory) {
  TissueState state = rows_at_rest(bodies.tets().size(), std::move(memory));
  const auto put = [&](std::size_t tet, const ElementStress& s) {
    state.deformation_gradient[tet] = s.deformation_gradient.values;
    state.strain[tet] = to_tensor(s.strain);
    state.plastic_strain[tet] = to_tensor(s.plastic_strain);
    state.energy_density[tet] = s.energy_density;
    state.volume_ratio[tet] = s.volume_ratio;
    state.stress[tet] = to_tensor(s.stress);
  };
  const auto tet_of = [&](Index element) {
    return static_cast<std::size_t>(at(elements.tet_of_element(), element));
  };
  const std::vector<simd::Padded3> displacements = elements.displacements(threads, positions);
  constexpr std::size_t group = simd::element_group;
  static_assert(tissue_grain % group == 0);
  const auto count = static_cast<std::size_t>(elements.size());
  parallel::for_chunks(threads, count, tissue_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::GroupStress found;
    for (std::size_t e = begin; e < end; ++e) {
      if (e % group == 0) elements.find_group_stress(e, displacements, found);
      const auto element = static_cast<Index>(e);
      if (found.left[e % group] == 0) {
        put_row(found, e % group, state, tet_of(element));
      } else if (!elements.is_smoothed(element)) {
        put(tet_of(element), stress_of(elements.deformation(element, positions)));
      }
    }
  });
  const std::vector<HyperelasticResponse> smoothed = elements.smoothed_responses(threads, displacements);
  parallel::for_each(threads, smoothed.size(), tissue_grain, [&](std::size_t t) {
    const Index element = elements.smoothing().tets()[t].element;
    put(tet_of(element), stress_of(elements.deformation(element, positions), smoothed[t]));
  });
  return state;
}

TissueState tissue_of_tets(const parallel::Threads& threads, const Bodies& bodies, const Elements& elements,
                           std::span<const Vec3> positions, TissueState memory) {
  TissueState state = strain_of_tets(threads, bodies, elements, positions, std::move(memory));
  find_invariants(threads, state);
  return state;
}

TissueState tissue_of_points(const parallel::Threads& threads, const Bodies& bodies, const Elements& elements,
                             const Materials& materials, const TissueState& tets, TissueState memory) {
  TissueState points = rows_at_rest(bodies.points_rest().size(), std::move(memory));
  const Around around{bodies, elements, materials, elements_of_tets(bodies, elements)};
  parallel::for_each(threads, points.size(), tissue_grain, [&](std::size_t p) {
    const auto point = static_cast<Index>(p);
    const Index material = around.material_at(point);
    if (material < 0) return;
    Mean mean;
    for (const Index tet : bodies.point_tets()[point]) {
      if (around.material(tet) == material) mean.add(tets, static_cast<std::size_t>(tet), around.volume(tet));
    }
    mean.put(points, p);
  });
  find_invariants(threads, points);
  return points;
}

}  // namespace palpate::fem
