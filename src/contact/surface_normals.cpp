#include "contact/surface_normals.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <compare>
#include <cstring>
#include <limits>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 32768;
constexpr double smooth_cosine = 0.5;  // 60 degrees

std::size_t corner_of(const Triangle& triangle, Index point) {
  return static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), point) - triangle.begin());
}

/// The triangles of a point that are connected over smooth edges at it.
struct Fan {
  Index body;
  Index length;  ///< number of triangles
  Index point;
  Index first;  ///< triangle; the others follow counter-clockwise
  friend auto operator<=>(const Fan&, const Fan&) = default;
};

/// Calls f(triangle, corner) for each triangle of a fan, from the first on.
template <class Across, class F>
void for_each_triangle(std::span<const Triangle> triangles, const Across& across, const Fan& fan, F&& f) {
  Index t = fan.first;
  do {
    const std::size_t corner = corner_of(at(triangles, t), fan.point);
    f(t, corner);
    t = at(across, t)[(corner + 1) % 3];
  } while (t >= 0 && t != fan.first);
}

/// Weights of a point of a triangle, none negative, sum 1; all equal where the triangle has no area. As
/// simd::find_normals() computes them.
std::array<double, 3> weights_at(const std::array<Vec3, 3>& corners, const Vec3& x) {
  const std::array<Vec3, 3> to{corners[0] - x, corners[1] - x, corners[2] - x};
  const std::array<Vec3, 3> part{cross(to[1], to[2]), cross(to[2], to[0]), cross(to[0], to[1])};
  const Vec3 area = part[0] + part[1] + part[2];
  std::array<double, 3> w{};
  double total = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    w[i] = dot(part[i], area);
    w[i] = w[i] > 0.0 ? w[i] : 0.0;
    total += w[i];
  }
  const double inverse = 1.0 / total;
  const bool has_area = inverse <= std::numeric_limits<double>::max();
  for (double& weight : w) weight = has_area ? inverse * weight : 1.0 / 3.0;
  return w;
}

/// Sum of the area vectors of a ring's triangles, as simd::find_ring_normals() computes it.
Vec3 area_of_ring(std::span<const Vec3> positions, Index center, std::span<const Index> ring) {
  const Vec3& c = at(positions, center);
  Vec3 area;
  Vec3 before = at(positions, ring[0]) - c;
  for (const Index point : ring.subspan(1)) {
    const Vec3 now = at(positions, point) - c;
    area += cross(before, now);
    before = now;
  }
  return area;
}

/// Several threads may write the same value.
void set_mark(std::uint8_t& mark, std::uint8_t value) {
  std::atomic_ref<std::uint8_t>(mark).store(value, std::memory_order_relaxed);
}
std::uint8_t get_mark(std::uint8_t& mark) {
  return std::atomic_ref<std::uint8_t>(mark).load(std::memory_order_relaxed);
}

}  // namespace

SurfaceNormals::SurfaceNormals(const Bodies& bodies) {
  find_rings(bodies, find_creases(bodies));
}

SurfaceNormals::Across SurfaceNormals::find_creases(const Bodies& bodies) {
  const std::span<const Triangle> triangles = bodies.triangles();
  creases_.assign(triangles.size(), 0);
  Across across(bodies.triangle_neighbors().begin(), bodies.triangle_neighbors().end());
  std::vector<std::uint8_t> on_crease(bodies.points_rest().size(), 0);
  std::vector<Vec3> normals(triangles.size());
  std::ranges::transform(triangles, normals.begin(),
                         [&](const Triangle& t) { return normalized(area_vector(bodies.points_rest(), t)); });
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      Index& other = across[t][i];
      if (other >= 0 && dot(normals[t], at(normals, other)) >= smooth_cosine) continue;
      other = -1;
      creases_[t] |= static_cast<std::uint8_t>(1U << i);
      at(on_crease, triangles[t][(i + 1) % 3]) = at(on_crease, triangles[t][(i + 2) % 3]) = 1;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (at(on_crease, triangles[t][i]) != 0) creases_[t] |= static_cast<std::uint8_t>(8U << i);
    }
  }
  return across;
}

void SurfaceNormals::find_rings(const Bodies& bodies, const Across& across) {
  const std::span<const Triangle> triangles = bodies.triangles();
  triangles_.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) triangles_[t] = {triangles[t], {-1, -1, -1}};
  std::vector<Fan> fans;
  for (Index seed = 0; seed < static_cast<Index>(triangles.size()); ++seed) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (at(triangles_, seed).rings[i] >= 0) continue;
      const Index point = at(triangles, seed)[i];
      const auto clockwise = [&](Index t) {
        return at(across, t)[(corner_of(at(triangles, t), point) + 2) % 3];
      };
      Fan fan{bodies.body_of(at(triangles, seed)), 0, point, seed};
      for (Index t = clockwise(seed); t >= 0 && t != seed; t = clockwise(t)) fan.first = t;
      for_each_triangle(triangles, across, fan, [&](Index t, std::size_t corner) {
        at(triangles_, t).rings[corner] = 0;
        ++fan.length;
      });
      fans.push_back(fan);
    }
  }
  std::ranges::sort(fans);
  rings_of_point_.begin.assign(bodies.points_rest().size() + 1, 0);
  for (const Fan& fan : fans) {
    const auto ring = static_cast<Index>(center_.size());
    center_.push_back(fan.point);
    ++at(rings_of_point_.begin, fan.point + 1);
    const Triangle& first = at(triangles, fan.first);
    rings_.values.push_back(first[(corner_of(first, fan.point) + 1) % 3]);
    for_each_triangle(triangles, across, fan, [&](Index t, std::size_t corner) {
      at(triangles_, t).rings[corner] = ring;
      rings_.values.push_back(at(triangles, t)[(corner + 2) % 3]);
    });
    rings_.begin.push_back(static_cast<Index>(rings_.values.size()));
  }
  for (std::size_t p = 0; p + 1 < rings_of_point_.begin.size(); ++p)
    rings_of_point_.begin[p + 1] += rings_of_point_.begin[p];
  rings_of_point_.values.resize(center_.size());
  std::vector<Index> next(rings_of_point_.begin.begin(), rings_of_point_.begin.end() - 1);
  for (std::size_t ring = 0; ring < center_.size(); ++ring)
    at(rings_of_point_.values, at(next, center_[ring])++) = static_cast<Index>(ring);
  marks_.assign(center_.size(), unknown);
  // Later steps allocate no memory.
  prepared_rings_.reserve(center_.size());
  lists_.make_room_in_all(parallel::chunk_count(center_.size(), grain), std::min(center_.size(), grain));
  areas_.resize(center_.size());
  units_.resize(center_.size());
}

void SurfaceNormals::prepare(const parallel::Threads& threads, std::span<const Vec3> positions,
                             std::span<const Crossing> crossings) {
  for (const Index ring : prepared_rings_) at(marks_, ring) = unknown;
  prepared_rings_.clear();
  parallel::for_chunks(threads, crossings.size(), 4096, [&](std::size_t begin, std::size_t end, std::size_t) {
    std::uint8_t* const marks = marks_.data();  // stays in a register, although bytes are written
    const simd::SmoothTriangle* const triangles = triangles_.data();
    for (const Crossing& crossing : crossings.subspan(begin, end - begin)) {
      const auto& [a, b, c] = triangles[crossing.triangle].rings;
      set_mark(marks[a], wanted);
      set_mark(marks[b], wanted);
      set_mark(marks[c], wanted);
    }
  });
  prepare_wanted(threads, positions);
}

void SurfaceNormals::want(Index triangle) {
  for (const Index ring : at(triangles_, triangle).rings) {
    std::uint8_t& mark = at(marks_, ring);
    if (get_mark(mark) == unknown) set_mark(mark, wanted);
  }
}

void SurfaceNormals::prepare_wanted(const parallel::Threads& threads, std::span<const Vec3> positions) {
  lists_.fill(
      threads, marks_.size(), grain, [&](std::size_t begin, std::size_t end, std::vector<Index>& found) {
        constexpr std::uint64_t any_wanted = 0x0101010101010101U * wanted;  // of eight marks at a time
        static_assert(std::endian::native == std::endian::little);
        for (std::size_t i = begin; i < end; i += sizeof any_wanted) {
          std::uint64_t marks = 0;
          std::memcpy(&marks, &marks_[i], std::min(end - i, sizeof marks));
          for (std::uint64_t left = marks & any_wanted; left != 0; left &= left - 1) {
            const std::size_t ring = i + static_cast<std::size_t>(std::countr_zero(left)) / 8;
            marks_[ring] = prepared;
            found.push_back(static_cast<Index>(ring));
          }
        }
      });
  const std::size_t before = prepared_rings_.size();
  lists_.append(prepared_rings_, parallel::chunk_count(marks_.size(), grain));
  const std::span<const Index> added = std::span<const Index>(prepared_rings_).subspan(before);
  parallel::for_chunks(threads, added.size(), 512, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::find_ring_normals(rings(positions), added.subspan(begin, end - begin), areas_, units_);
  });
}

/// Distance of a point of a triangle from the nearest crease, in heights of the triangle; at most 1.
double SurfaceNormals::from_crease(Index triangle, const std::array<double, 3>& w) const {
  const unsigned creases = at(creases_, triangle);
  double distance = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((creases & (1U << i)) != 0) distance = std::min(distance, w[i]);
    if ((creases & (8U << i)) != 0) distance = std::min(distance, 1.0 - w[i]);
  }
  return distance;
}

/// \param area_of  function: sum of the area vectors of a ring
/// \param unit_of  function: its unit vector
template <class AreaOfRing, class UnitOfRing>
Vec3 SurfaceNormals::interpolated(std::span<const Vec3> positions, Index triangle, const Vec3& x,
                                  const AreaOfRing& area_of, const UnitOfRing& unit_of) const {
  const simd::SmoothTriangle& t = at(triangles_, triangle);
  const std::array<Vec3, 3> corners = corners_of(positions, t.corners);
  const std::array<double, 3> w = weights_at(corners, x);
  Vec3 smooth;
  for (std::size_t i = 0; i < 3; ++i) smooth += w[i] * unit_of(t.rings[i]);
  Vec3 normal = smooth;
  const double from_crease = this->from_crease(triangle, w);
  if (from_crease < band) {
    Vec3 joined;
    for (std::size_t i = 0; i < 3; ++i) {
      Vec3 of_point;
      for (const Index ring : rings_of_point_[t.corners[i]]) of_point += area_of(ring);
      joined += w[i] * normalized(of_point);
    }
    const double fraction = 1.0 - from_crease / band;
    normal = (1.0 - fraction) * smooth + fraction * joined;
  }
  normal = normalized(normal);
  return normal == Vec3{} ? normalized(area_vector(corners)) : normal;
}

Vec3 SurfaceNormals::at_point(std::span<const Vec3> positions, Index triangle, const Vec3& x) const {
  const auto area_of = [&](Index ring) {
    return at(marks_, ring) == prepared ? at(areas_, ring)
                                        : area_of_ring(positions, at(center_, ring), rings_[ring]);
  };
  return interpolated(positions, triangle, x, area_of, [&](Index ring) { return at(units_, ring); });
}

Vec3 SurfaceNormals::at_point_now(std::span<const Vec3> positions, Index triangle, const Vec3& x) const {
  const auto area_of = [&](Index ring) { return area_of_ring(positions, at(center_, ring), rings_[ring]); };
  return interpolated(positions, triangle, x, area_of, [&](Index ring) { return normalized(area_of(ring)); });
}

void SurfaceNormals::at_points(std::span<const Vec3> positions, std::span<const simd::PointOfTriangle> points,
                               std::span<Vec3> normals, std::span<simd::Doubtful> scratch) const {
  const std::size_t doubtful = simd::find_normals(smooth(positions), points, normals, scratch);
  for (const simd::Doubtful& d : scratch.first(doubtful)) {
    const auto& [triangle, x] = points[d.item];
    if (needs_more(triangle, d)) normals[d.item] = at_point(positions, triangle, x);
  }
}

}  // namespace palpate
