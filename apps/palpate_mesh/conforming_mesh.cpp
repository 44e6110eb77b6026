#include "conforming_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "line_balls.hpp"
#include "map_fit.hpp"
#include "size_search.hpp"
#include "sliver_repair.hpp"

namespace palpate::app {
namespace {

/// Largest size of triangles, relative to the thickness of the tissue there. With larger triangles the two
/// sides of a layer would touch. Layers of few voxels have smaller ratios, with which they stay whole (tests,
/// Conforming.LayersOfOneVoxel...).
constexpr double of_thickness = 4.0;
constexpr double of_one_voxel = 1.2;
constexpr double of_each_more = 1.6;
/// Largest distance of triangles from the interface, relative to their size, and relative to a voxel.
constexpr double size_fraction = 0.12;
constexpr double distance_voxels = 1.0 / 3.0;
/// Largest size by which lines where three tissues meet are divided, in voxels. With larger ones, pieces of
/// few voxels beside the lines are lost.
constexpr double line_voxels = 3.0;
constexpr double default_tets = 55000.0;

Tissues tissues_of(const NamedMap& map, const TissuePlan& plan, const Shaping& shaping) {
  std::vector<LabelExtent> extents;
  extents.reserve(map.labels.size());
  for (const NamedLabel& label : map.labels) extents.push_back(label.extent);
  Tissues tissues(map.map, extents, shaping.smoothing);
  if (shaping.gap <= 0.0) return tissues;
  const auto tissue_of = [&](std::int32_t label) {
    const auto found = std::ranges::find(extents, label, &LabelExtent::label);
    return found == extents.end() ? 0 : static_cast<int>(found - extents.begin()) + 1;
  };
  for (int t = 1; t <= tissues.count(); ++t) {
    const auto is_open = [&](std::int32_t label) {
      const int other = tissue_of(label);
      return other > 0 && other != t && plan.relations.between(t, other) == Relation::open;
    };
    auto distance = distance_to_labels(map.map, extents[static_cast<std::size_t>(t - 1)], shaping, is_open);
    if (distance) tissues.draw_back(t, std::move(*distance), shaping.gap);
  }
  return tissues;
}

/// The thickness of layers, scaled down for layers of few voxels, so that `of_thickness` times it is the
/// wanted size. A voxel that sticks out of a thick tissue is not a layer: it gets the thickness of its
/// neighbours.
std::vector<float> layers_of(const Tissues& tissues, double most) {
  const std::vector<float> thickness = thickness_of(tissues, most);
  const Vec3& s = tissues.spacing();
  const double voxel = std::max({s.x, s.y, s.z});
  std::vector<float> layers;
  layers.reserve(thickness.size());
  for_points(tissues.size(), [&](int i, int j, int k) {
    const int tissue = tissues.voxel(i, j, k);
    float thick = 0.0F;
    for_points({3, 3, 3}, [&](int x, int y, int z) {
      const std::array<int, 3> v{i + x - 1, j + y - 1, k + z - 1};
      for (std::size_t a = 0; a < 3; ++a) {
        if (v[a] < 0 || v[a] >= tissues.size()[a]) return;
      }
      if (tissues.voxel(v[0], v[1], v[2]) == tissue)
        thick = std::max(thick, thickness[tissues.voxel_index(v[0], v[1], v[2])]);
    });
    const double voxels = std::max(static_cast<double>(thick) / voxel, 1.0);
    const double ratio = std::min(of_one_voxel + of_each_more * (voxels - 1.0), of_thickness);
    layers.push_back(thick * static_cast<float>(ratio / of_thickness));
  });
  return layers;
}

class ConformingMesher {
 public:
  ConformingMesher(const NamedMap& map, const TissuePlan& plan, const MeshOptions& options,
                   const MeshingProgress& progress)
      : plan_(&plan),
        options_(&options),
        progress_(&progress),
        tissues_(tissues_of(map, plan, options.shaping)),
        lines_(tissue_lines(tissues_)),
        layers_(layers_of(tissues_, most_thickness(map))) {
    for (const NamedLabel& label : map.labels) voxels_ += static_cast<double>(label.extent.voxels);
    domain_.lower = tissues_.lower();
    domain_.upper = tissues_.upper();
    domain_.label = [this](const Vec3& p) { return tissues_.at(p); };
  }
  ConformingMesher(const ConformingMesher&) = delete;
  ConformingMesher& operator=(const ConformingMesher&) = delete;

  ConformingMesh make() {
    const Fineness& fineness = options_->fineness;
    if (fineness.size > 0.0) {
      mesh(fineness.size, {});
    } else {
      search(fineness.tets > 0.0 ? fineness.tets : default_tets);
    }
    if (made_.mesh.mesh.tets.empty()) fail_empty();
    repair_slivers(made_.mesh,
                   {.reach = [&](const Vec3& p) { return distance(p); }, .check = progress_->check});
    fit_interfaces(made_.mesh, tissues_, progress_->check);
    made_.wanted_tets = fineness.size > 0.0 ? 0.0 : fineness.tets;
    made_.faces = interface_faces(made_.mesh);
    made_.bodies = bodies_of(made_.mesh, made_.faces, plan_->relations, plan_->rigid, plan_->names);
    made_.comparison = compare(tissues_, lines_, made_.mesh, made_.faces);
    made_.least_size = static_cast<double>(*std::ranges::min_element(sizes_.values));
    return std::move(made_);
  }

 private:
  /// Thicknesses above this are not measured: some dozen voxels.
  static double most_thickness(const NamedMap& map) {
    constexpr double voxels = 12.0;
    return voxels * std::max({map.map.spacing.x, map.map.spacing.y, map.map.spacing.z});
  }

  /// Meshes at a general size; layers have sizes of their own, and stay whole unless a number of tets was
  /// given. Slivers are improved only where `wanted` accepts the number of tets.
  void mesh(double size, const std::function<bool(std::size_t)>& wanted) {
    progress_->starts(size);
    made_.size = size;
    TissueSizes sizes = plan_->sizes;
    sizes.general = size;
    sizes.of_thickness =
        of_thickness * (options_->fineness.tets > 0.0 ? scale_of(size) : std::min(scale_of(size), 1.0));
    sizes_ = size_field(tissues_, sizes, layers_);
    const double longest = line_voxels * voxel() * scale_of(size);
    domain_.lines = line_balls(lines_, [&](const Vec3& p) { return std::min(sizes_(p), longest); });
    const Fineness& fineness = options_->fineness;
    const MeshingCriteria criteria{
        .facet_size = [&](const Vec3& p) { return sizes_(p); },
        .facet_distance = [&](const Vec3& p) { return distance(p); },
        .cell_size = [&](const Vec3& p) { return fineness.cell_ratio * sizes_(p); },
        .max_points = fineness.max_points,
        .manifold = false,
        .wanted = wanted,
        .check = progress_->check};
    // A thin sheet may need more seeds than its size asks for, since CGAL may find no triangle to start with.
    constexpr std::array<double, 5> seeds_apart{1.0, 0.5, 0.25, 0.125, 0.0625};  // sizes
    std::optional<LabelledMesh> found;
    for (const double apart : seeds_apart) {
      domain_.seeds = tissues_.seeds(apart * size);
      found = mesh_domain(domain_, criteria);
      if (!found || !found->mesh.tets.empty()) break;
    }
    if (!found) {
      throw Error("meshing", "", fmt::format("more than {} points", fineness.max_points),
                  "a larger --size, fewer --tets, or more --max-points");
    }
    made_.mesh = std::move(*found);
    ++made_.meshings;
  }

  /// Names the tissue that has the smallest size.
  [[noreturn]] void fail_empty() const {
    double least = std::numeric_limits<double>::infinity();
    std::string name;
    for (std::size_t v = 0; v < sizes_.values.size(); ++v) {
      const auto size = static_cast<double>(sizes_.values[v]);
      const std::size_t tissue = tissues_.voxels()[v];
      if (tissue == 0 || size >= least) continue;
      least = size;
      name = plan_->names[tissue - 1];
    }
    throw Error(name, "", fmt::format("no tet at size {:.3g} mm", least), "a smaller --size, or more --tets");
  }

  [[nodiscard]] double voxel() const {
    const Vec3& s = tissues_.spacing();
    return std::cbrt(s.x * s.y * s.z);
  }
  [[nodiscard]] double distance(const Vec3& p) const {
    const double most = distance_voxels * voxel() * scale_of(made_.size);
    return std::min(size_fraction * sizes_(p), most);
  }

  /// If a number of tets is given, sizes in layers are proportional to the general size.
  [[nodiscard]] double scale_of(double size) const { return first_size_ > 0.0 ? size / first_size_ : 1.0; }

  void search(double tets) {
    constexpr double lost_as_slivers = 1.04;
    constexpr double near = 0.03;
    constexpr double much_finer = -2.0;
    constexpr int most = 6;
    constexpr double wide =
        3.0;  // relative to tets that fill the volume evenly, since most tets are in layers
    constexpr double tets_in_a_cube = 6.0;
    first_size_ = wide * voxel() * std::cbrt(voxels_ * tets_in_a_cube / tets);
    SizeSearch tried;
    double size = first_size_;
    double best_size = size;
    double best_off = std::numeric_limits<double>::infinity();
    for (int meshing = 0; meshing < most; ++meshing) {
      double off = 0.0;
      bool taken = false;
      mesh(size, [&](std::size_t count) {
        off = std::log(std::max(static_cast<double>(count), 1.0) / (lost_as_slivers * tets));
        off = std::max(off, much_finer);  // a mesh with holes says little about its number of tets
        return taken = std::abs(off) <= near;
      });
      if (taken) return;
      if (std::abs(off) < best_off) {
        best_off = std::abs(off);
        best_size = size;
      }
      tried.add(size, off);
      size = tried.next();
    }
    mesh(best_size, {});
  }

  const TissuePlan* plan_;
  const MeshOptions* options_;
  const MeshingProgress* progress_;
  Tissues tissues_;
  TissueLines lines_;
  std::vector<float> layers_;
  LabelledDomain domain_;
  Lattice sizes_;
  ConformingMesh made_;
  double voxels_ = 0.0;
  double first_size_ = 0.0;
};

}  // namespace

ConformingMesh mesh_conforming(const NamedMap& map, const TissuePlan& plan, const MeshOptions& options,
                               const MeshingProgress& progress) {
  return ConformingMesher(map, plan, options, progress).make();
}

}  // namespace palpate::app
