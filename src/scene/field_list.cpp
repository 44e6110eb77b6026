#include "scene/field_list.hpp"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

constexpr std::array infos{
    FieldInfo{"contact_force", dimension::force, 3, false, "contact force",
              "force of contacts on each point of a surface"},
    FieldInfo{"contact_traction", dimension::pressure, 3, false, "contact traction",
              "force of contacts per area"},
    FieldInfo{"contact_pressure", dimension::pressure, 1, false, "contact pressure",
              "the part of it against the outward normal"},
    FieldInfo{"reaction", dimension::force, 3, false, "reaction",
              "reaction at points that are fixed or prescribed"},
    FieldInfo{"deformation_gradient", dimension::none, 9, true, "deformation gradient",
              "F, from the shape at rest"},
    FieldInfo{"strain", dimension::none, 6, true, "strain", "Green's strain"},
    FieldInfo{"stress", dimension::pressure, 6, true, "stress",
              "Cauchy stress, elastic; tension is positive"},
    FieldInfo{"von_mises", dimension::pressure, 1, true, "von Mises stress", "von Mises stress"},
    FieldInfo{"pressure", dimension::pressure, 1, true, "pressure", "-trace(stress) / 3"},
    FieldInfo{"principal_stress", dimension::pressure, 3, true, "principal stress",
              "eigenvalues of the stress, largest first"},
    FieldInfo{"principal_directions", dimension::none, 9, true, "principal directions",
              "their unit vectors, in that order"},
    FieldInfo{"energy_density", dimension::pressure, 1, true, "energy density",
              "elastic energy per volume at rest"},
    FieldInfo{"plastic_strain", dimension::none, 6, true, "plastic strain",
              "plastic strain, in the corotated frame of the tet"},
    FieldInfo{"volume_ratio", dimension::none, 1, true, "volume ratio", "volume over volume at rest"}};

constexpr auto names = [] {
  std::array<std::string_view, infos.size()> list{};
  for (std::size_t i = 0; i < infos.size(); ++i) list[i] = infos[i].name;
  return list;
}();

}  // namespace

std::span<const FieldInfo> field_infos() {
  return infos;
}

const FieldInfo* find_field(std::string_view name) {
  const auto* const found = std::ranges::find(infos, name, &FieldInfo::name);
  return found == infos.end() ? nullptr : &*found;
}

std::span<const std::string_view> field_names() {
  return names;
}

}  // namespace palpate
