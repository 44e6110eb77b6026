#include "tissue_presets.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vector>

#include <palpate/tissues.hpp>

#include "messages.hpp"
#include "scene/units.hpp"

namespace palpate::app {
namespace {

std::string_view name_of(Tissue tissue) {
  return tissue_names[static_cast<std::size_t>(tissue)];
}

}  // namespace

void warn_of_presets(const Scene& scene) {
  std::vector<std::string_view> found;
  const auto add = [&](const Material& material) {
    if (material.tissue && std::ranges::count(found, name_of(*material.tissue)) == 0)
      found.push_back(name_of(*material.tissue));
  };
  for (const SceneBody& body : scene.bodies) {
    if (body.material) add(*body.material);
    for (const Region& region : body.regions) add(region.material);
  }
  if (found.empty()) return;
  say_warning(
      fmt::format("values of {} are presets, starting points alone: people and states of tissue differ by a "
                  "factor of two and more (docs/materials.md)",
                  fmt::join(found, ", ")));
}

std::string tissue_lines() {
  std::string text = "\n\nTissues that a scene may name (material.tissue), with their Young's moduli:\n";
  for (std::size_t i = 0; i < tissue_names.size(); ++i) {
    const TissueInfo& info = tissue_info(static_cast<Tissue>(i));
    text += fmt::format("  {:<16} {:<10} {}\n", tissue_names[i],
                        in_words(info.young_modulus, {}, dimension::pressure), info.source);
  }
  return text + "They are starting points: sources and spread are in docs/materials.md.";
}

}  // namespace palpate::app
