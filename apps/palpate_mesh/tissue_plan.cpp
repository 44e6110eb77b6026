#include "tissue_plan.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

#include "components.hpp"
#include "exit_codes.hpp"
#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

constexpr std::string_view outside = "outside";

/// The tissue of a name or number of a label; 0 for "outside", -1 where there is none.
int tissue_named(const NamedMap& map, std::string_view word) {
  for (std::size_t t = 0; t < map.labels.size(); ++t) {
    const NamedLabel& label = map.labels[t];
    if (label.name.name == word || std::to_string(label.extent.label) == word) return static_cast<int>(t) + 1;
  }
  return word == outside ? 0 : -1;
}

/// The two tissues of "A:B", ascending; a name may contain colons.
std::array<int, 2> tissue_pair(const NamedMap& map, const std::string& flag, const std::string& words,
                               int lowest) {
  for (std::size_t colon = words.find(':'); colon != std::string::npos; colon = words.find(':', colon + 1)) {
    const int a = tissue_named(map, std::string_view(words).substr(0, colon));
    const int b = tissue_named(map, std::string_view(words).substr(colon + 1));
    if (std::min(a, b) >= lowest && a != b) return {std::min(a, b), std::max(a, b)};
  }
  std::string known;
  for (const NamedLabel& label : map.labels) known += (known.empty() ? "" : ", ") + label.name.name;
  throw BadInput(flag, "", "'" + words + "'", "two organs ORGAN:ORGAN of " + known);
}

Vec3 in_map(const Frame& frame, const Vec3& p) {
  const Vec3 from = p - frame.origin;
  return {dot(from, frame.axes[0]), dot(from, frame.axes[1]), dot(from, frame.axes[2])};
}

TissueSizes sizes_of(const MeshOptions& options, const NamedMap& map) {
  TissueSizes sizes;
  sizes.own.assign(map.labels.size() + 1, 0.0);
  for (const auto& [organ, size] : options.fineness.sizes)
    sizes.own[static_cast<std::size_t>(tissue_named(map, organ))] = size;
  for (const auto& [organs, size] : options.conformity.interface_sizes)
    sizes.interfaces.push_back({tissue_pair(map, "--size", organs, 0), size});
  const Frame frame = in_space(map.map.frame, options.ras);
  for (const auto& [center, radius, size] : options.conformity.focuses)
    sizes.focuses.push_back({in_map(frame, center), radius, size});
  return sizes;
}

bool touches_border(const LabelMap& map, const LabelExtent& extent) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (extent.box.lower[a] == 0 || extent.box.upper[a] == map.size[a] - 1) return true;
  }
  return false;
}

/// The tissue of each voxel, 0 for none.
std::vector<std::uint16_t> tissues_of_voxels(const NamedMap& map) {
  std::vector<std::uint16_t> tissues;
  tissues.reserve(map.map.labels.size());
  std::int32_t last = 0;
  std::uint16_t tissue = 0;
  for (const std::int32_t label : map.map.labels) {
    if (label != last) {
      const auto found = std::ranges::find(map.labels, label, [](const auto& l) { return l.extent.label; });
      tissue = static_cast<std::uint16_t>(
          found == map.labels.end() ? 0 : std::distance(map.labels.begin(), found) + 1);
      last = label;
    }
    tissues.push_back(tissue);
  }
  return tissues;
}

/// Tissues with voxels that share a face.
TissuePairs touching(const NamedMap& map) {
  const std::vector<std::uint16_t> tissues = tissues_of_voxels(map);
  const auto row = static_cast<std::size_t>(map.map.size[0]);
  const auto slice = row * static_cast<std::size_t>(map.map.size[1]);
  TissuePairs pairs;
  const auto add = [&](std::size_t a, std::size_t b) {
    const int one = std::min(tissues[a], tissues[b]);
    const int other = std::max(tissues[a], tissues[b]);
    if (one > 0 && one != other) pairs.insert({one, other});
  };
  for (std::size_t v = 0; v < tissues.size(); ++v) {
    if (v % row > 0) add(v - 1, v);
    if (v % slice >= row) add(v - row, v);
    if (v >= slice) add(v - slice, v);
  }
  return pairs;
}

/// The sizes of the components of each label, by its index among the labels of the map.
std::vector<std::vector<std::size_t>> parts_of_labels(const NamedMap& map) {
  const std::vector<std::uint16_t> labels = tissues_of_voxels(map);
  const Components components = components_of(map.map.size, labels);
  std::vector<std::vector<std::size_t>> parts(map.labels.size());
  for (std::size_t c = 0; c < components.sizes.size(); ++c)
    parts[components.labels[c] - std::size_t{1}].push_back(components.sizes[c]);
  return parts;
}

}  // namespace

TissuePlan plan_of(const MeshOptions& options, const NamedMap& map) {
  TissuePlan plan;
  for (const NamedLabel& label : map.labels) {
    plan.names.push_back(label.name.name);
    plan.rigid.push_back(std::ranges::count(options.rigid, label.name.name) > 0);
  }
  plan.relations.general = options.conformity.general.value_or(Relation::grown);
  for (const auto& [organs, relation] : options.conformity.pairs) {
    const int one = tissue_named(map, organs);
    if (one < 1) plan.relations.pairs.push_back({tissue_pair(map, "--relation", organs, 1), relation});
    for (int t = 1; one > 0 && t <= static_cast<int>(map.labels.size()); ++t) {
      if (t != one) plan.relations.pairs.push_back({{std::min(one, t), std::max(one, t)}, relation});
    }
  }
  plan.sizes = sizes_of(options, map);
  return plan;
}

void check_plan(const TissuePlan& plan, const NamedMap& map) {
  check_relations(touching(map), plan.relations, plan.rigid, plan.names);
}

std::vector<std::string> label_warnings(const NamedMap& map) {
  constexpr std::size_t few = 27;
  const auto parts = parts_of_labels(map);
  std::vector<std::string> warnings;
  for (std::size_t t = 0; t < map.labels.size(); ++t) {
    const auto& [extent, name] = map.labels[t];
    if (touches_border(map.map, extent))
      warnings.push_back(name.name + ": touches the border of the map, and ends there in a flat wall");
    if (extent.voxels < few) {
      warnings.push_back(
          fmt::format("{}: only {} {}", name.name, extent.voxels, extent.voxels == 1 ? "voxel" : "voxels"));
    }
    if (parts[t].size() > 1) {
      const std::size_t largest = *std::ranges::max_element(parts[t]);
      const std::size_t rest = extent.voxels - largest;
      warnings.push_back(fmt::format("{}: {} parts; {} {} not in the largest", name.name, parts[t].size(),
                                     rest, rest == 1 ? "voxel is" : "voxels are"));
    }
  }
  return warnings;
}

}  // namespace palpate::app
