#include "conforming_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "numbers.hpp"
#include "size_search.hpp"

namespace palpate::app {
namespace {

using nlohmann::ordered_json;

const std::string& name_of(const TissuePlan& plan, int tissue) {
  return plan.names[static_cast<std::size_t>(tissue - 1)];
}

std::string_view relation_of(const TissuePlan& plan, const InterfaceMatch& match) {
  return relation_names[static_cast<std::size_t>(plan.relations.between(match.tissues[0], match.tissues[1]))];
}

ordered_json distance_json(const ShapeDistance& distance) {
  return {{"mean", distance.mean}, {"95", distance.percentile_95}, {"max", distance.largest}};
}

ordered_json tissue_json(const TissueMatch& match, const NamedLabel& label) {
  return {{"name", utf8_text(label.name.name)},
          {"label", label.extent.label},
          {"tets", match.tets},
          {"min_dihedral_angle", match.least_angle},
          {"volume", match.volume},
          {"input_volume", match.map_volume},
          {"dice", match.dice},
          {"lost_voxels", match.lost},
          {"surface_distance", distance_json(match.distance)}};
}

ordered_json interface_json(const InterfaceMatch& match, const TissuePlan& plan) {
  return {
      {"tissues", {utf8_text(name_of(plan, match.tissues[0])), utf8_text(name_of(plan, match.tissues[1]))}},
      {"relation", relation_of(plan, match)},
      {"triangles", match.triangles},
      {"area", match.area},
      {"input_area", match.map_area},
      {"closed_area", match.closed_area}};
}

/// Fraction of the area between tissues that is closed in the mesh, without open pairs; nothing if there is
/// no such area.
std::optional<double> closed_fraction(const ConformingMesh& made, const TissuePlan& plan) {
  double closed = 0.0;
  double all = 0.0;
  for (const InterfaceMatch& match : made.comparison.interfaces) {
    if (plan.relations.between(match.tissues[0], match.tissues[1]) == Relation::open) continue;
    closed += match.closed_area;
    all += match.map_area;
  }
  return all > 0.0 ? std::optional(closed / all) : std::nullopt;
}

/// Number of points that tets of both tissues have.
std::size_t common_points(const LabelledMesh& mesh, const std::array<int, 2>& tissues) {
  std::vector<std::array<bool, 2>> has(mesh.mesh.points.size());
  for (std::size_t t = 0; t < mesh.labels.size(); ++t) {
    for (std::size_t i = 0; i < 2; ++i) {
      if (mesh.labels[t] != tissues[i]) continue;
      for (const Index p : mesh.mesh.tets[t]) at(has, p)[i] = true;
    }
  }
  return static_cast<std::size_t>(std::ranges::count(has, std::array{true, true}));
}

double least_angle(const ConformingMesh& made) {
  double least = 180.0;
  for (const TissueMatch& match : made.comparison.tissues) least = std::min(least, match.least_angle);
  return least;
}

/// Indices of the focuses that do not reach the box of the mesh.
std::vector<std::size_t> focuses_outside(const ConformingMesh& made, const TissuePlan& plan) {
  Box box;
  for (const Vec3& point : made.mesh.mesh.points) box.extend(point);
  std::vector<std::size_t> outside;
  for (std::size_t f = 0; f < plan.sizes.focuses.size(); ++f) {
    const auto& [center, radius, size] = plan.sizes.focuses[f];
    const Vec3 nearest{std::clamp(center.x, box.lower.x, box.upper.x),
                       std::clamp(center.y, box.lower.y, box.upper.y),
                       std::clamp(center.z, box.lower.z, box.upper.z)};
    if (length(center - nearest) > radius) outside.push_back(f);
  }
  return outside;
}

std::vector<std::string> warnings_of(const ConformingMesh& made, const TissuePlan& plan) {
  constexpr double similar = 0.95;
  constexpr double flat = 8.0;
  constexpr double off = 0.1;
  constexpr double closed = 0.99;
  std::vector<std::string> warnings;
  for (std::size_t t = 0; t < plan.names.size(); ++t) {
    const TissueMatch& match = made.comparison.tissues[t];
    if (match.tets == 0) {
      warnings.push_back(plan.names[t] + ": not in the mesh: use a smaller size for it");
      continue;
    }
    if (match.lost > 0) {
      warnings.push_back(fmt::format("{}: {} of {} voxels are lost: use a smaller size for it", plan.names[t],
                                     match.lost, match.voxels));
    }
    if (match.dice < similar) {
      warnings.push_back(
          fmt::format("{}: Dice {:.3f}: use a smaller size for it", plan.names[t], match.dice));
    }
    if (std::abs(match.volume / match.map_volume - 1.0) > off) {
      warnings.push_back(fmt::format("{}: {:.1f} % of the volume of its voxels: use a smaller size for it",
                                     plan.names[t], 100.0 * match.volume / match.map_volume));
    }
    if (match.least_angle < flat)
      warnings.push_back(fmt::format("{}: flat tets, {:.1f} degrees", plan.names[t], match.least_angle));
  }
  for (const InterfaceMatch& match : made.comparison.interfaces) {
    if (plan.relations.between(match.tissues[0], match.tissues[1]) != Relation::open) continue;
    if (const std::size_t points = common_points(made.mesh, match.tissues); points > 0) {
      warnings.push_back(fmt::format("{} and {} are open, but share {}: use a larger --gap or a smaller size",
                                     name_of(plan, match.tissues[0]), name_of(plan, match.tissues[1]),
                                     counted(points, "point")));
    }
  }
  if (const auto fraction = closed_fraction(made, plan); fraction && *fraction < closed) {
    warnings.push_back(
        fmt::format("only {:.1f} % of the area where organs touch in the map is closed", 100.0 * *fraction));
  }
  for (const std::size_t focus : focuses_outside(made, plan)) {
    warnings.push_back(
        fmt::format("--focus number {} does not reach the mesh, and has no effect", focus + 1));
  }
  if (made.wanted_tets > 0.0) {
    if (auto missed = missed_number(static_cast<double>(made.mesh.labels.size()), made.wanted_tets))
      warnings.push_back(std::move(*missed));
  }
  return warnings;
}

std::string text_of(const ConformingMesh& made, const TissuePlan& plan) {
  constexpr std::size_t longest = 32;
  std::size_t width = 6;
  for (const std::string& name : plan.names) width = std::max(width, std::min(longest, name.size()));
  std::string text =
      fmt::format("{:<{}}  {:>7}  {:>9}  {:>11}  {:>11}  {:>6}  {:>12}  {:>12}\n", "tissue", width, "tets",
                  "min angle", "volume cm^3", "% of labels", "Dice", "mean dist mm", "95 % dist mm");
  for (std::size_t t = 0; t < plan.names.size(); ++t) {
    const TissueMatch& match = made.comparison.tissues[t];
    text += fmt::format("{:<{}}  {:>7}  {:>9.1f}  {:>11.4g}  {:>11.1f}  {:>6.3f}  {:>12.2f}  {:>12.2f}\n",
                        shortened(plan.names[t], width), width, match.tets, match.least_angle,
                        1e-3 * match.volume, 100.0 * match.volume / match.map_volume, match.dice,
                        match.distance.mean, match.distance.percentile_95);
  }
  if (const auto fraction = closed_fraction(made, plan))
    text += fmt::format("{:.2f} % of the area where organs touch is closed; ", 100.0 * *fraction);
  text += fmt::format("sizes {} to {} mm\n", short_text(made.least_size), short_text(made.size));
  if (const auto& lines = made.comparison.lines) {
    text += fmt::format(
        "lines where three meet: {:.2f} mm from those of the labels (mean), 95 % within {:.2f} mm\n",
        lines->mean, lines->percentile_95);
  }
  return text;
}

}  // namespace

ConformingReport conforming_report(const ConformingMesh& made, const std::vector<BodyFile>& files,
                                   const NamedMap& map, const TissuePlan& plan) {
  ConformingReport report;
  const std::optional<double> fraction = closed_fraction(made, plan);
  report.json = {{"mesh", "tissues.vtu"},
                 {"points", made.mesh.mesh.points.size()},
                 {"tets", made.mesh.mesh.tets.size()},
                 {"min_dihedral_angle", least_angle(made)},
                 {"closed_fraction", fraction ? ordered_json(*fraction) : ordered_json(nullptr)},
                 {"size", made.size},
                 {"least_size", made.least_size},
                 {"meshings", made.meshings},
                 {"line_distance",
                  made.comparison.lines ? distance_json(*made.comparison.lines) : ordered_json(nullptr)},
                 {"bodies", ordered_json::array()},
                 {"tissues", ordered_json::array()},
                 {"interfaces", ordered_json::array()}};
  for (std::size_t b = 0; b < files.size(); ++b) {
    ordered_json tissues = ordered_json::array();
    for (const int t : made.bodies[b].tissues) tissues.push_back(utf8_text(name_of(plan, t)));
    report.json["bodies"].push_back({{"name", utf8_text(files[b].name)},
                                     {"file", files[b].file},
                                     {"tissues", tissues},
                                     {"points", made.bodies[b].mesh.points.size()},
                                     {"tets", made.bodies[b].mesh.tets.size()}});
  }
  for (std::size_t t = 0; t < plan.names.size(); ++t)
    report.json["tissues"].push_back(tissue_json(made.comparison.tissues[t], map.labels[t]));
  for (const InterfaceMatch& match : made.comparison.interfaces)
    report.json["interfaces"].push_back(interface_json(match, plan));
  report.text = text_of(made, plan);
  report.warnings = warnings_of(made, plan);
  return report;
}

}  // namespace palpate::app
