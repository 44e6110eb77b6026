#include "mesh_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <palpate/error.hpp>

#include "domain_mesher.hpp"
#include "geometry/vector.hpp"
#include "size_search.hpp"
#include "stopwatch.hpp"

namespace palpate::app {
namespace {

/// Number of parts of a mesh that are connected through faces.
int component_count(const TetMesh& mesh) {
  Bodies bodies;
  bodies.add("mesh", mesh);
  std::vector<bool> seen(mesh.tets.size());
  std::vector<std::size_t> open;
  int components = 0;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first]) continue;
    ++components;
    seen[first] = true;
    open.push_back(first);
    while (!open.empty()) {
      const auto tet = open.back();
      open.pop_back();
      for (const Index next : bodies.tet_neighbors()[tet]) {
        if (next < 0 || seen[static_cast<std::size_t>(next)]) continue;
        seen[static_cast<std::size_t>(next)] = true;
        open.push_back(static_cast<std::size_t>(next));
      }
    }
  }
  return components;
}

/// The next number with two digits.
double rounded_up(double number) {
  const double unit = std::pow(10.0, std::floor(std::log10(number)) - 1.0);
  return unit * std::ceil(number / unit);
}

class Mesher {
 public:
  Mesher(const std::vector<Organ>& organs, const Fineness& fineness, const MeshingStarts& starts,
         const std::function<void()>& check)
      : organs_(&organs), fineness_(&fineness), starts_(&starts), check_(&check), meshed_(organs.size()) {
    for (std::size_t o = 0; o < organs.size(); ++o)
      meshed_[o].shape_volume = positive_volume(organs[o].field);
  }

  /// Meshes an organ at one size. Throws Error if that needs more points than the user allows.
  void mesh(std::size_t organ, double size) {
    if (!mesh(organ, size, fineness_->max_points)) fail_points(fineness_->max_points);
  }

  /// Meshes some organs to a number of tets together.
  void search(const std::vector<std::size_t>& group, double wanted) {
    constexpr double tets_in_a_cube = 6.0;  // first guess: tets in a cube whose edges have the wanted size
    constexpr double near = 0.02;
    constexpr int most = 8;
    constexpr double most_work = 12.0;    // limit on the tets of all meshings, relative to the wanted number
    constexpr double whole_volume = 0.5;  // triangles that are far larger than a sheet is thick leave holes
    constexpr double finer = -0.5;        // logarithms of a number of tets after which the size is smaller
    constexpr double much_finer = -2.0;
    double volume = 0.0;
    for (const std::size_t organ : group) volume += meshed_[organ].shape_volume;
    if (!(volume > 0.0)) fail_volume(group.front());
    double size = std::cbrt(volume * tets_in_a_cube / wanted);
    const std::size_t most_points = points_for(wanted);
    SizeSearch tried;
    double best_off = std::numeric_limits<double>::infinity();
    double best_tets = 0.0;
    std::vector<MeshedOrgan> best;
    double work = 0.0;
    for (int meshing = 0; meshing < most; ++meshing) {
      const std::optional<double> tets = mesh(group, size, most_points);
      double off = std::log(std::max(tets.value_or(6.0 * static_cast<double>(most_points)), 1.0) / wanted);
      const bool whole = tets && volume_of(group) > whole_volume * volume;
      if (tets && !whole) off = std::clamp(off, much_finer, finer);  // its number of tets says nothing
      tried.add(size, off);
      if (whole && std::abs(off) < best_off) {
        best_off = std::abs(off);
        best_tets = *tets;
        best = meshes_of(group);
      }
      work += std::exp(off);
      if (std::abs(off) <= near || (work > most_work && !best.empty())) break;
      if (tried.coarser_does_not_help()) break;
      size = tried.next();
    }
    if (best.empty()) fail_search(group, wanted, most_points);
    if (const auto missed = missed_number(best_tets, wanted))
      warnings_.push_back(fmt::format("{}: {}", names_of(group), *missed));
    for (std::size_t g = 0; g < group.size(); ++g) {
      MeshedOrgan& organ = meshed_[group[g]];
      const int meshings = organ.meshings;
      const double seconds = organ.seconds;
      organ = best[g];
      organ.meshings = meshings;
      organ.seconds = seconds;
    }
  }

  MeshedOrgans take() {
    for (std::size_t o = 0; o < meshed_.size(); ++o) finish((*organs_)[o], meshed_[o]);
    return {std::move(meshed_), std::move(warnings_)};
  }

 private:
  /// Meshes one organ and replaces its last mesh. Returns the number of tets; none where it needs more
  /// points.
  std::optional<double> mesh(std::size_t index, double size, std::size_t most_points) {
    (*starts_)(index, size);
    Stopwatch watch;
    const Organ& organ = (*organs_)[index];
    const Lattice& field = organ.field;
    LabelledDomain shape;
    shape.lower = field.origin;
    shape.upper = field.place(field.size[0] - 1, field.size[1] - 1, field.size[2] - 1);
    shape.label = [&](const Vec3& p) { return field(p) > 0.0 ? 1 : 0; };
    MeshedOrgan& meshed = meshed_[index];
    meshed.mesh = {};
    // A slender organ may need more seeds than its size asks for, since CGAL may find no triangle to start
    // with.
    constexpr std::array<double, 4> seeds_apart{2.0, 1.0, 0.5, 0.25};  // sizes
    const auto everywhere = [](double value) { return [value](const Vec3&) { return value; }; };
    const MeshingCriteria criteria{.facet_size = everywhere(size),
                                   .facet_distance = everywhere(fineness_->distance_ratio * size),
                                   .cell_size = everywhere(fineness_->cell_ratio * size),
                                   .max_points = most_points,
                                   .manifold = true,
                                   .wanted = {},
                                   .check = *check_};
    std::optional<LabelledMesh> made;
    for (const double apart : seeds_apart) {
      const SurfaceSeeds seeds = surface_seeds(field, apart * size);
      meshed.shape_components = seeds.components;
      shape.seeds.clear();
      for (const Vec3& point : seeds.points) shape.seeds.push_back({point, {0, 1}});
      made = mesh_domain(shape, criteria);
      if (!made || !made->mesh.tets.empty()) break;
    }
    meshed.size = size;
    ++meshed.meshings;
    meshed.seconds += watch.lap();
    if (!made) return {};
    meshed.mesh = std::move(made->mesh);
    meshed.manifold = made->manifold;
    return static_cast<double>(meshed.mesh.tets.size());
  }

  /// Meshes some organs at one size and replaces their last meshes. Returns the number of tets; none where
  /// one of them needs more points.
  std::optional<double> mesh(const std::vector<std::size_t>& group, double size, std::size_t most_points) {
    double sum = 0.0;
    for (const std::size_t organ : group) {
      const std::optional<double> tets = mesh(organ, size, most_points);
      if (!tets) return {};
      sum += *tets;
    }
    return sum;
  }

  /// A generous limit on the points of a mesh of so many tets. Without a limit, a shape that is no manifold
  /// would be refined for ever.
  [[nodiscard]] std::size_t points_for(double tets) const {
    constexpr double least = 4000.0;
    constexpr double of_a_tet = 2.0;  // points per tet; good meshes have 0.2 to 0.35
    return std::min(fineness_->max_points, static_cast<std::size_t>(std::max(least, of_a_tet * tets)));
  }

  [[noreturn]] static void fail_points(std::size_t points) {
    throw Error("meshing", "", fmt::format("more than {} points", points),
                "a larger --size, fewer --tets, or more --max-points");
  }

  /// Says how many tets a thin shape needs, where that is the reason.
  [[noreturn]] void fail_search(const std::vector<std::size_t>& group, double wanted,
                                std::size_t most_points) const {
    constexpr double tets_in_a_thickness = 5.0;  // in a cube of it: 4.3 to 6.4 in sheets of 0.5 to 2 mm
    double least = 0.0;
    double thinnest = std::numeric_limits<double>::infinity();
    for (const std::size_t organ : group) {
      const double known = (*organs_)[organ].thickness;
      const double thick = known > 0.0 ? known : mean_thickness((*organs_)[organ].field);
      least += tets_in_a_thickness * (*organs_)[organ].input_volume / (thick * thick * thick);
      thinnest = std::min(thinnest, thick);
    }
    if (!(least > wanted)) fail_points(most_points);
    throw Error(names_of(group), "", fmt::format("no whole mesh of about {:.0f} tets", wanted),
                fmt::format("about {:.0f} tets or more where a shape is {:.3g} mm thick (mean)",
                            rounded_up(least), thinnest));
  }

  /// Volume of the last meshes.
  [[nodiscard]] double volume_of(const std::vector<std::size_t>& group) const {
    double sum = 0.0;
    for (const std::size_t organ : group) {
      const TetMesh& mesh = meshed_[organ].mesh;
      for (const Tet& tet : mesh.tets) {
        const Vec3& p = at(mesh.points, tet[0]);
        sum += dot(at(mesh.points, tet[1]) - p,
                   cross(at(mesh.points, tet[2]) - p, at(mesh.points, tet[3]) - p)) /
               6.0;
      }
    }
    return sum;
  }

  [[noreturn]] void fail_volume(std::size_t organ) const {
    const Vec3& spacing = (*organs_)[organ].field.spacing;
    throw Error((*organs_)[organ].name, "", "a mesh without volume",
                fmt::format("a shape thicker than {:.3g} mm in at least one place",
                            std::min({spacing.x, spacing.y, spacing.z})));
  }

  [[nodiscard]] std::string names_of(const std::vector<std::size_t>& group) const {
    const std::string& first = (*organs_)[group.front()].name;
    return group.size() == 1 ? first : fmt::format("{} and {} more", first, group.size() - 1);
  }

  [[nodiscard]] std::vector<MeshedOrgan> meshes_of(const std::vector<std::size_t>& group) const {
    std::vector<MeshedOrgan> meshes;
    meshes.reserve(group.size());
    for (const std::size_t organ : group) meshes.push_back(meshed_[organ]);
    return meshes;
  }

  static void finish(const Organ& organ, MeshedOrgan& meshed) {
    if (meshed.mesh.tets.empty()) {
      throw Error(organ.name, "", fmt::format("no tet at size {:.3g} mm", meshed.size),
                  "a smaller --size, or more --tets");
    }
    for (Vec3& point : meshed.mesh.points) point = organ.frame.to_world(point);
    check_mesh(meshed.mesh, organ.name);  // turns the tets of a left-handed image
    meshed.mesh_components = component_count(meshed.mesh);
  }

  const std::vector<Organ>* organs_;
  const Fineness* fineness_;
  const MeshingStarts* starts_;
  const std::function<void()>* check_;
  std::vector<MeshedOrgan> meshed_;
  std::vector<std::string> warnings_;
};

std::optional<double> named(const std::vector<Fineness::Named>& values, const std::string& organ) {
  for (const auto& value : values) {
    if (value.organ == organ) return value.value;
  }
  return std::nullopt;
}

}  // namespace

MeshedOrgans mesh_organs(const std::vector<Organ>& organs, const Fineness& fineness,
                         const MeshingStarts& starts, const std::function<void()>& check) {
  Mesher mesher(organs, fineness, starts, check);
  std::vector<std::size_t> together;
  for (std::size_t o = 0; o < organs.size(); ++o) {
    if (const auto size = named(fineness.sizes, organs[o].name)) {
      mesher.mesh(o, *size);
    } else if (const auto tets = named(fineness.named_tets, organs[o].name)) {
      mesher.search(std::vector{o}, *tets);
    } else if (fineness.size > 0.0) {
      mesher.mesh(o, fineness.size);
    } else if (fineness.tets_each > 0.0) {
      mesher.search(std::vector{o}, fineness.tets_each);
    } else {
      together.push_back(o);
    }
  }
  if (!together.empty()) mesher.search(together, fineness.tets);
  return mesher.take();
}

}  // namespace palpate::app
