#include "scene/field_values.hpp"

#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include <palpate/error.hpp>

#include "scene/suggest.hpp"

namespace palpate {
namespace {

/// The rows as one list of numbers, in memory order.
template <class Row>
std::vector<double> numbers(const std::vector<Row>& rows) {
  static_assert(sizeof(Row) % sizeof(double) == 0 && std::is_trivially_copyable_v<Row>);
  const auto* const first = reinterpret_cast<const double*>(rows.data());
  return {first, first + rows.size() * sizeof(Row) / sizeof(double)};
}

std::vector<double> of_tissue(const TissueState& state, std::string_view name) {
  if (name == "deformation_gradient") return numbers(state.deformation_gradient);
  if (name == "strain") return numbers(state.strain);
  if (name == "stress") return numbers(state.stress);
  if (name == "von_mises") return state.von_mises;
  if (name == "pressure") return state.pressure;
  if (name == "principal_stress") return numbers(state.principal_stress);
  if (name == "principal_directions") return numbers(state.principal_directions);
  if (name == "energy_density") return state.energy_density;
  if (name == "plastic_strain") return numbers(state.plastic_strain);
  return state.volume_ratio;
}

/// The data from which fields are computed. Each is computed when it is first used.
class Sources {
 public:
  explicit Sources(const Simulation& simulation) : simulation_(simulation) {}

  const TissueState& tets() {
    if (!tets_) tets_ = simulation_.tissue();
    return *tets_;
  }
  const TissueState& points() {
    if (!points_) points_ = tets_ ? simulation_.tissue_at_points(*tets_) : simulation_.tissue_at_points();
    return *points_;
  }
  const SurfaceTractions& surface() {
    if (!surface_) surface_ = simulation_.tractions();
    return *surface_;
  }
  std::vector<double> at_points(const FieldInfo& info) {
    if (info.of_tets) return of_tissue(points(), info.name);
    if (info.name == "contact_force") return numbers(surface().point_forces);
    if (info.name == "contact_traction") return numbers(surface().point_traction);
    if (info.name == "contact_pressure") return surface().point_pressure;
    return reactions();
  }

 private:
  [[nodiscard]] std::vector<double> reactions() const {
    if (simulation_.metrics().step == 0) return std::vector<double>(3 * simulation_.positions().size(), 0.0);
    const std::span<const Vec3> all = simulation_.reactions();
    return numbers(std::vector<Vec3>(all.begin(), all.end()));
  }

  const Simulation& simulation_;
  std::optional<TissueState> tets_;
  std::optional<TissueState> points_;
  std::optional<SurfaceTractions> surface_;
};

const FieldInfo& field_named(const std::string& name) {
  const FieldInfo* const info = find_field(name);
  if (info == nullptr) throw Error("fields", "", "'" + name + "'", expected_name(name, field_names()));
  return *info;
}

}  // namespace

FieldArrays field_arrays(const Simulation& simulation, std::span<const std::string> names) {
  FieldArrays arrays;
  Sources sources(simulation);
  for (const std::string& name : names) {
    const FieldInfo& info = field_named(name);
    // Tets first: means at points are computed from them.
    if (info.of_tets) arrays.of_tets.push_back({&info, of_tissue(sources.tets(), info.name)});
    arrays.of_points.push_back({&info, sources.at_points(info)});
  }
  return arrays;
}

FieldArray field_array(const Simulation& simulation, const std::string& name, bool of_tets) {
  const FieldInfo& info = field_named(name);
  if (of_tets && !info.of_tets) throw Error("fields", "", "'" + name + "' of tets", "a field of tissue");
  Sources sources(simulation);
  return {&info, of_tets ? of_tissue(sources.tets(), info.name) : sources.at_points(info)};
}

std::vector<double> row_sizes(std::vector<double> values, int components) {
  const auto width = static_cast<std::size_t>(components);
  if (width == 1) return values;
  std::vector<double> lengths(values.size() / width);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    double squares = 0.0;
    for (std::size_t k = 0; k < width; ++k) squares += values[width * i + k] * values[width * i + k];
    lengths[i] = std::sqrt(squares);
  }
  return lengths;
}

std::vector<double> point_scalars(const Simulation& simulation, const std::string& name) {
  FieldArray field = field_array(simulation, name, false);
  return row_sizes(std::move(field.values), field.info->components);
}

}  // namespace palpate
