#include "tissues.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "components.hpp"
#include "geometry/vector.hpp"
#include "thinner.hpp"

namespace palpate::app {
namespace {

constexpr int blur_margin = 2;  // voxels around the map, so that the blur of labels at its border ends inside
constexpr std::int16_t several = -1;

std::vector<std::uint16_t> tissue_of_voxels(const LabelMap& map, const std::vector<LabelExtent>& extents) {
  std::map<std::int32_t, std::uint16_t> tissue;
  for (const LabelExtent& extent : extents)
    tissue.emplace(extent.label, static_cast<std::uint16_t>(tissue.size() + 1));
  std::vector<std::uint16_t> voxels;
  voxels.reserve(map.labels.size());
  for (const std::int32_t label : map.labels) {
    const auto found = label == 0 ? tissue.end() : tissue.find(label);
    voxels.push_back(found == tissue.end() ? std::uint16_t{0} : found->second);
  }
  return voxels;
}

/// Indices of the cell that contains p, counted from the lowest corner of all cells.
std::array<int, 3> cell_at(const Vec3& p, const Vec3& spacing) {
  const auto along = [](double x, double step) {
    return static_cast<int>(std::floor(x / step)) + blur_margin;
  };
  return {along(p.x, spacing.x), along(p.y, spacing.y), along(p.z, spacing.z)};
}

}  // namespace

Tissues::Tissues(const LabelMap& map, const std::vector<LabelExtent>& extents, double smoothing)
    : size_(map.size), spacing_(map.spacing), voxels_(tissue_of_voxels(map, extents)) {
  Shaping shaping;
  shaping.smoothing = smoothing;
  for (const LabelExtent& extent : extents) fields_.push_back(blurred_mask(map, extent, shaping));
  offsets_.assign(fields_.size(), 0.0);
  free_.resize(fields_.size());
  for (std::size_t a = 0; a < 3; ++a) cells_[a] = size_[a] + 2 * blur_margin - 1;
  find_winners();
  keep_volumes(extents, blur_width(map, shaping));
}

Vec3 Tissues::lower() const {
  return {-blur_margin * spacing_.x, -blur_margin * spacing_.y, -blur_margin * spacing_.z};
}

Vec3 Tissues::upper() const {
  return {(size_[0] - 1 + blur_margin) * spacing_.x, (size_[1] - 1 + blur_margin) * spacing_.y,
          (size_[2] - 1 + blur_margin) * spacing_.z};
}

int Tissues::evaluated(const Vec3& p) const {
  double rest = 1.0;
  double most = 0.0;
  int best = 0;
  for (std::size_t t = 0; t < fields_.size(); ++t) {
    const Lattice& field = fields_[t];
    const Vec3 end = field.place(field.size[0] - 1, field.size[1] - 1, field.size[2] - 1);
    if (p.x < field.origin.x || p.y < field.origin.y || p.z < field.origin.z) continue;
    if (p.x > end.x || p.y > end.y || p.z > end.z) continue;
    const double value = field(p);
    rest -= value;
    if (value <= 0.0 || value + offsets_[t] <= most) continue;
    most = value + offsets_[t];
    best = static_cast<int>(t) + 1;
  }
  if (rest >= most) return 0;
  return best > 0 && is_drawn_back(best, p) ? 0 : best;
}

bool Tissues::is_drawn_back(int tissue, const Vec3& p) const {
  const Lattice& free = free_[static_cast<std::size_t>(tissue - 1)];
  return !free.values.empty() && free(p) <= 0.0;
}

int Tissues::at(const Vec3& p) const {
  const std::array<int, 3> cell = cell_at(p, spacing_);
  for (std::size_t a = 0; a < 3; ++a) {
    if (cell[a] < 0 || cell[a] >= cells_[a]) return 0;
  }
  const std::int16_t whole = cell_[cell_index(cell[0], cell[1], cell[2])];
  return whole == several ? evaluated(p) : whole;
}

std::size_t Tissues::cell_index(int i, int j, int k) const {
  const auto row =
      static_cast<std::size_t>(k) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(j);
  return row * static_cast<std::size_t>(cells_[0]) + static_cast<std::size_t>(i);
}

int Tissues::voxel(int i, int j, int k) const {
  if (i < 0 || j < 0 || k < 0 || i >= size_[0] || j >= size_[1] || k >= size_[2]) return 0;
  return voxels_[voxel_index(i, j, k)];
}

std::size_t Tissues::voxel_index(int i, int j, int k) const {
  const auto row =
      static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(j);
  return row * static_cast<std::size_t>(size_[0]) + static_cast<std::size_t>(i);
}

/// A cell is of one tissue if all voxels within a distance of one from its corners are: values are
/// interpolated between the corners, and the blur does not reach further.
void Tissues::find_winners() {
  cell_.assign(static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) *
                   static_cast<std::size_t>(cells_[2]),
               several);
  for_points(cells_, [&](int i, int j, int k) {
    const int first = voxel(i - blur_margin, j - blur_margin, k - blur_margin);
    bool same = true;
    for_points({4, 4, 4}, [&](int x, int y, int z) {
      same =
          same && voxel(i - blur_margin + x - 1, j - blur_margin + y - 1, k - blur_margin + z - 1) == first;
    });
    if (same) cell_[cell_index(i, j, k)] = static_cast<std::int16_t>(first);
  });
}

/// Takes eight samples in each cell of several tissues, one in each octant. Their positions differ from cell
/// to cell (Roberts 2018, additive recurrence of the plastic number), because a regular lattice of samples
/// would miss flat layers between its planes.
std::vector<double> Tissues::volumes() const {
  constexpr Vec3 steps{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  std::vector<double> volumes(fields_.size() + 1);
  const double voxel = spacing_.x * spacing_.y * spacing_.z;
  double mixed = 0.0;  // number of cells with several tissues so far
  for_points(cells_, [&](int i, int j, int k) {
    const std::int16_t whole = cell_[cell_index(i, j, k)];
    if (whole != several) {
      volumes[static_cast<std::size_t>(whole)] += voxel;
      return;
    }
    mixed += 1.0;
    const auto place = [&](int half, double step) {
      return 0.5 * (half + mixed * step - std::floor(mixed * step));
    };
    for_points({2, 2, 2}, [&](int x, int y, int z) {
      const Vec3 p{(i - blur_margin + place(x, steps.x)) * spacing_.x,
                   (j - blur_margin + place(y, steps.y)) * spacing_.y,
                   (k - blur_margin + place(z, steps.z)) * spacing_.z};
      volumes[static_cast<std::size_t>(evaluated(p))] += 0.125 * voxel;
    });
  });
  return volumes;
}

std::vector<double> Tissues::surface_areas() const {
  std::vector<double> areas(fields_.size() + 1);
  const std::array<double, 3> face{spacing_.y * spacing_.z, spacing_.x * spacing_.z, spacing_.x * spacing_.y};
  for_points({size_[0] + 1, size_[1] + 1, size_[2] + 1}, [&](int i, int j, int k) {
    const int here = voxel(i, j, k);
    for (int a = 0; a < 3; ++a) {
      const int before = voxel(i - (a == 0 ? 1 : 0), j - (a == 1 ? 1 : 0), k - (a == 2 ? 1 : 0));
      if (before == here) continue;
      areas[static_cast<std::size_t>(here)] += face[static_cast<std::size_t>(a)];
      areas[static_cast<std::size_t>(before)] += face[static_cast<std::size_t>(a)];
    }
  });
  return areas;
}

/// Finds offsets by iteration: an offset moves the interfaces of a tissue by half of it over the slope of the
/// blur.
void Tissues::keep_volumes(const std::vector<LabelExtent>& extents, double width) {
  constexpr int rounds = 6;
  constexpr double most = 0.3;
  const std::vector<double> areas = surface_areas();
  const double voxel = spacing_.x * spacing_.y * spacing_.z;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<double> volumes = this->volumes();
    for (std::size_t t = 0; t < offsets_.size(); ++t) {
      const double missing = static_cast<double>(extents[t].voxels) * voxel - volumes[t + 1];
      offsets_[t] = std::clamp(offsets_[t] + 2.0 * missing / (areas[t + 1] * width), -most, most);
    }
  }
}

void Tissues::draw_back(int tissue, Lattice distance_to_others, double gap) {
  Lattice& free = free_[static_cast<std::size_t>(tissue - 1)];
  free = std::move(distance_to_others);
  for (float& value : free.values) value -= static_cast<float>(0.5 * gap);
  for_points(cells_, [&](int i, int j, int k) {
    std::int16_t& whole = cell_[cell_index(i, j, k)];
    if (whole != tissue) return;
    bool all = true;
    for_points({2, 2, 2}, [&](int x, int y, int z) {
      all = all && free({(i - blur_margin + x) * spacing_.x, (j - blur_margin + y) * spacing_.y,
                         (k - blur_margin + z) * spacing_.z}) > 0.0;
    });
    if (!all) whole = several;
  });
}

std::vector<InterfaceSeed> Tissues::seeds(double apart) const {
  const Components components = components_of(size_, voxels_);
  const double voxel_volume = spacing_.x * spacing_.y * spacing_.z;
  const auto component = [&](int i, int j, int k) {
    if (voxel(i, j, k) == 0) return -1;
    return components.of[voxel_index(i, j, k)];
  };
  const auto spacing_of = [&](int part) {
    constexpr double of_a_small_one = 0.6;  // some dozen points on a ball
    if (part < 0) return apart;
    const auto points = static_cast<double>(components.sizes[static_cast<std::size_t>(part)]);
    return std::min(apart, of_a_small_one * std::cbrt(points * voxel_volume));
  };
  std::map<std::pair<int, int>, Thinner> thinners;
  std::vector<InterfaceSeed> seeds;
  for_points({size_[0] + 1, size_[1] + 1, size_[2] + 1}, [&](int i, int j, int k) {
    for (int a = 0; a < 3; ++a) {
      const std::array<int, 3> before{i - (a == 0 ? 1 : 0), j - (a == 1 ? 1 : 0), k - (a == 2 ? 1 : 0)};
      const Vec3 high{i * spacing_.x, j * spacing_.y, k * spacing_.z};
      const Vec3 low{before[0] * spacing_.x, before[1] * spacing_.y, before[2] * spacing_.z};
      const auto seed = crossing(low, high);
      if (!seed) continue;
      const std::pair<int, int> parts =
          std::minmax(component(i, j, k), component(before[0], before[1], before[2]));
      const double spacing = std::min(spacing_of(parts.first), spacing_of(parts.second));
      if (thinners.try_emplace(parts, Thinner(spacing)).first->second.take(seed->point))
        seeds.push_back(*seed);
    }
  });
  return seeds;
}

std::optional<InterfaceSeed> Tissues::crossing(Vec3 low, Vec3 high) const {
  constexpr int halvings = 20;
  const int from = at(low);
  if (at(high) == from) return std::nullopt;
  for (int i = 0; i < halvings; ++i) {
    const Vec3 middle = 0.5 * (low + high);
    (at(middle) == from ? low : high) = middle;
  }
  const int to = at(high);
  return InterfaceSeed{0.5 * (low + high), {std::min(from, to), std::max(from, to)}};
}

}  // namespace palpate::app
