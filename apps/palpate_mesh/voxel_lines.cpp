#include "voxel_lines.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "mesh/faces.hpp"

namespace palpate::app {
namespace {

constexpr std::array<double Vec3::*, 3> coordinate{&Vec3::x, &Vec3::y, &Vec3::z};

/// The interval of a line through `start` along an axis that is in a tet, in coordinates of that axis.
std::optional<std::pair<double, double>> part_in(const std::array<Vec3, 4>& tet, const Vec3& start,
                                                 std::size_t axis, const Box& box) {
  const auto along = coordinate[axis];
  double low = box.lower.*along;
  double high = box.upper.*along;
  for (const auto& [a, b, c] : outward_face) {
    const Vec3 normal = cross(tet[b] - tet[a], tet[c] - tet[a]);
    const double off = dot(normal, start - tet[a]);  // > 0: outside
    const double slope = normal.*along;
    if (slope == 0.0) {
      if (off > 0.0) return std::nullopt;
      continue;
    }
    const double end = start.*along - off / slope;
    (slope > 0.0 ? high : low) = slope > 0.0 ? std::min(high, end) : std::max(low, end);
  }
  if (low > high) return std::nullopt;
  return std::pair(low, high);
}

class TetTracer {
 public:
  TetTracer(const Tissues& tissues, VoxelLines& lines) : tissues_(&tissues), lines_(&lines) {
    lines.tissues.assign(tissues.voxels().size(), 0);
    for (auto& covered : lines.covered) covered.assign(tissues.voxels().size(), 0.0F);
  }

  void add(const std::array<Vec3, 4>& tet, int tissue) {
    Box box;
    for (const Vec3& corner : tet) box.extend(corner);
    std::array<int, 3> first{};
    std::array<int, 3> last{};
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = std::max(0, static_cast<int>(std::ceil(box.lower.*coordinate[a] / step(a))));
      last[a] =
          std::min(tissues_->size()[a] - 1, static_cast<int>(std::floor(box.upper.*coordinate[a] / step(a))));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<int, 3> count{};
      for (std::size_t a = 0; a < 3; ++a) count[a] = a == axis ? 1 : std::max(last[a] - first[a] + 1, 0);
      for_points(count, [&](int i, int j, int k) {
        std::array<int, 3> voxel{first[0] + i, first[1] + j, first[2] + k};
        voxel[axis] = 0;
        const Vec3 start{voxel[0] * step(0), voxel[1] * step(1), voxel[2] * step(2)};
        if (const auto part = part_in(tet, start, axis, box)) cover(voxel, axis, *part, tissue);
      });
    }
  }

 private:
  [[nodiscard]] double step(std::size_t axis) const { return tissues_->spacing().*coordinate[axis]; }

  void cover(std::array<int, 3> voxel, std::size_t axis, const std::pair<double, double>& part, int tissue) {
    const int most = tissues_->size()[axis] - 1;
    const int begin = std::max(0, static_cast<int>(std::ceil(part.first / step(axis))));
    const int end = std::min(most, static_cast<int>(std::floor(part.second / step(axis))) + 1);
    for (int at = begin; at <= end; ++at) {
      voxel[axis] = at;
      const std::size_t v = tissues_->voxel_index(voxel[0], voxel[1], voxel[2]);
      const double here = at * step(axis);
      const double length = std::min(part.second, here) - std::max(part.first, here - step(axis));
      if (length > 0.0) lines_->covered[axis][v] += static_cast<float>(length);
      if (axis == 0 && part.first <= here && here <= part.second)
        lines_->tissues[v] = static_cast<std::uint16_t>(tissue);
    }
  }

  const Tissues* tissues_;
  VoxelLines* lines_;
};

}  // namespace

VoxelLines covered_lines(const Tissues& tissues, const LabelledMesh& mesh) {
  VoxelLines lines;
  TetTracer tracer(tissues, lines);
  for (std::size_t t = 0; t < mesh.mesh.tets.size(); ++t) {
    std::array<Vec3, 4> corners;
    for (std::size_t c = 0; c < 4; ++c)
      corners[c] = mesh.mesh.points[static_cast<std::size_t>(mesh.mesh.tets[t][c])];
    tracer.add(corners, mesh.labels[t]);
  }
  return lines;
}

}  // namespace palpate::app
