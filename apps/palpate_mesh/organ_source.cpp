#include "organ_source.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include <palpate/error.hpp>

#include "exit_codes.hpp"
#include "label_table.hpp"
#include "scene/suggest.hpp"

namespace palpate::app {
namespace {

std::string expected_organ(const std::string& word, const std::vector<std::string>& names) {
  return expected_name(word, std::vector<std::string_view>(names.begin(), names.end()));
}

/// Throws BadInput if a flag names an organ that does not exist.
void check_names(const std::string& flag, const std::vector<std::string>& wanted,
                 const std::vector<std::string>& names) {
  for (const std::string& word : wanted) {
    if (std::ranges::count(names, word) == 0)
      throw BadInput(flag, "", "'" + word + "'", expected_organ(word, names));
  }
}

std::vector<std::string> words_of(const std::vector<Fineness::Named>& values) {
  std::vector<std::string> words;
  words.reserve(values.size());
  for (const auto& value : values) words.push_back(value.organ);
  return words;
}

void check_named_organs(const MeshOptions& options, const std::vector<std::string>& names) {
  check_names("--only", options.only, names);
  check_names("--rigid", options.rigid, names);
  check_names("--size", words_of(options.fineness.sizes), names);
  check_names("--tets", words_of(options.fineness.named_tets), names);
}

void make_unique(std::vector<NamedLabel>& labels) {
  std::set<std::string> seen;
  for (NamedLabel& label : labels) {
    if (!seen.insert(label.name.name).second) {
      label.name.name += fmt::format(" {}", label.name.label);
      seen.insert(label.name.name);
    }
  }
}

std::vector<NamedLabel> named_labels(const LabelMap& map, const std::vector<LabelName>& names) {
  std::vector<NamedLabel> labels;
  for (const LabelExtent& extent : labels_in(map)) {
    const auto name = std::ranges::find(names, extent.label, &LabelName::label);
    labels.push_back({extent, name == names.end() ? LabelName{extent.label, "", {}} : *name});
    if (labels.back().name.name.empty()) labels.back().name.name = fmt::format("label {}", extent.label);
  }
  make_unique(labels);
  return labels;
}

/// A remark on labels that have a name but no voxel; empty if there are none.
std::string empty_labels(const std::vector<NamedLabel>& labels, const std::vector<LabelName>& names) {
  constexpr std::size_t most = 5;
  std::vector<std::string> missing;
  for (const LabelName& name : names) {
    const bool is_there =
        std::ranges::any_of(labels, [&](const auto& l) { return l.extent.label == name.label; });
    if (name.label != 0 && !is_there) missing.push_back(fmt::format("{} ({})", name.label, name.name));
  }
  if (missing.empty()) return {};
  const std::size_t count = missing.size();
  missing.resize(std::min(count, most));
  return fmt::format("no voxel has label {}{}", fmt::join(missing, ", "),
                     count > most ? fmt::format(" and {} more of the table", count - most) : "");
}

/// Replaces numbers of labels in the flags by their names.
void use_names(MeshOptions& options, const std::vector<NamedLabel>& labels) {
  const auto use = [&](std::string& word) {
    for (const NamedLabel& label : labels) {
      if (word == std::to_string(label.extent.label)) word = label.name.name;
    }
  };
  for (auto* words : {&options.only, &options.rigid}) std::ranges::for_each(*words, use);
  for (auto* values : {&options.fineness.sizes, &options.fineness.named_tets}) {
    for (auto& value : *values) use(value.organ);
  }
}

void check_gap(const LabelMap& map, const Shaping& shaping, const std::string& source) {
  constexpr double most_voxels = 20.0;
  const double least = std::min({map.spacing.x, map.spacing.y, map.spacing.z});
  if (shaping.gap > most_voxels * least) {
    throw BadInput("--gap", source, fmt::format("{} mm", shaping.gap),
                   fmt::format("at most {} voxels: {} mm", most_voxels, most_voxels * least));
  }
}

/// Removes the sizes of interfaces, "A:B", which are handled separately.
void take_out_pairs(MeshOptions& options, const std::vector<std::string>& names) {
  if (!options.conformity.wanted) return;
  auto& sizes = options.fineness.sizes;
  const auto is_pair = [&](const Fineness::Named& size) {
    return std::ranges::count(names, size.organ) == 0 && size.organ.find(':') != std::string::npos;
  };
  std::ranges::copy_if(sizes, std::back_inserter(options.conformity.interface_sizes), is_pair);
  std::erase_if(sizes, is_pair);
}

OrganList organs_of_map(MeshOptions& options) {
  NamedMap read = read_named_map(options);
  const Vec3& spacing = read.map.spacing;
  OrganList list;
  list.warnings = std::move(read.warnings);
  for (const NamedLabel& label : read.labels) {
    list.organs.push_back({label.name.name,
                           label.name.color,
                           label_field(read.map, label.extent, options.shaping),
                           in_space(read.map.frame, options.ras),
                           static_cast<double>(label.extent.voxels) * (spacing.x * spacing.y * spacing.z),
                           {},
                           0.0});
  }
  return list;
}

OrganList organs_of_surfaces(const MeshOptions& options) {
  std::vector<std::string> known;
  for (const auto& input : options.inputs) {
    known.push_back(input.stem().string());
    if (std::ranges::count(known, known.back()) > 1) {
      throw BadInput(input.string(), "", "two organs with the name '" + known.back() + "'",
                     "files of different names");
    }
  }
  check_named_organs(options, known);
  OrganList list;
  for (std::size_t o = 0; o < known.size(); ++o) {
    if (!options.only.empty() && std::ranges::count(options.only, known[o]) == 0) continue;
    SurfaceShape shape = surface_field(options.inputs[o], options.shaping);
    Organ organ{known[o],       {}, std::move(shape.field), {}, shape.volume, std::move(shape.remarks),
                shape.thickness};
    organ.frame = in_space(organ.frame, options.ras);
    list.organs.push_back(std::move(organ));
  }
  return list;
}

}  // namespace

Frame in_space(Frame frame, bool ras) {
  if (!ras) return frame;
  const auto turn = [](Vec3& v) { v = {-v.x, -v.y, v.z}; };
  turn(frame.origin);
  for (Vec3& axis : frame.axes) turn(axis);
  return frame;
}

NamedMap read_named_map(MeshOptions& options) {
  const auto& input = options.inputs.front();
  NamedMap read{read_label_map(input), {}, {}};
  check_gap(read.map, options.shaping, input.string());
  const std::vector<LabelName> names = options.labels ? read_label_table(*options.labels) : read.map.names;
  read.labels = named_labels(read.map, names);
  if (read.labels.empty()) throw Error(input.string(), "", "no voxel that is not 0", "labels");
  use_names(options, read.labels);
  std::vector<std::string> known;
  known.reserve(read.labels.size());
  for (const NamedLabel& label : read.labels) known.push_back(label.name.name);
  take_out_pairs(options, known);
  check_named_organs(options, known);
  if (std::string warning = empty_labels(read.labels, names); !warning.empty())
    read.warnings.push_back(std::move(warning));
  if (!options.only.empty()) {
    std::erase_if(read.labels,
                  [&](const NamedLabel& l) { return std::ranges::count(options.only, l.name.name) == 0; });
  }
  return read;
}

OrganList read_organs(MeshOptions& options) {
  return is_label_map(options.inputs.front()) ? organs_of_map(options) : organs_of_surfaces(options);
}

}  // namespace palpate::app
