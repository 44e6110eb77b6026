#include "surface.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <numeric>
#include <tuple>
#include <utility>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolygon.h>

#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

/// For each point, the first point with the same coordinates.
std::vector<Index> first_at_place(const std::vector<Vec3>& points) {
  const auto key = [&](Index p) {
    const Vec3& place = at(points, p);
    return std::tuple(place.x, place.y, place.z, p);
  };
  std::vector<Index> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](Index a, Index b) { return key(a) < key(b); });
  std::vector<Index> first(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && at(points, order[i]) == at(points, order[i - 1]);
    at(first, order[i]) = same ? at(first, order[i - 1]) : order[i];
  }
  return first;
}

/// Triangles of a polygon by cutting off ears (vtkPolygon); a fan where that fails.
void append_triangles(const std::vector<Vec3>& points, const std::vector<Index>& polygon,
                      std::vector<Triangle>& triangles) {
  if (polygon.size() == 3) return triangles.push_back({polygon[0], polygon[1], polygon[2]});
  vtkNew<vtkPolygon> ears;
  ears->PointIds->SetNumberOfIds(static_cast<vtkIdType>(polygon.size()));
  ears->Points->SetDataTypeToDouble();
  ears->Points->SetNumberOfPoints(static_cast<vtkIdType>(polygon.size()));
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& p = at(points, polygon[i]);
    ears->PointIds->SetId(static_cast<vtkIdType>(i), static_cast<vtkIdType>(i));
    ears->Points->SetPoint(static_cast<vtkIdType>(i), p.x, p.y, p.z);
  }
  vtkNew<vtkIdList> corners;
  if (ears->Triangulate(corners) == 0) {
    for (std::size_t i = 2; i < polygon.size(); ++i)
      triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
    return;
  }
  const auto corner = [&](vtkIdType i) { return polygon[static_cast<std::size_t>(corners->GetId(i))]; };
  for (vtkIdType i = 0; i + 2 < corners->GetNumberOfIds(); i += 3)
    triangles.push_back({corner(i), corner(i + 1), corner(i + 2)});
}

/// A triangle with its points sorted, and whether that order is an even permutation of its own.
struct Facing {
  Triangle sorted;
  bool ascends;
  std::size_t number;
};

Facing facing(const Triangle& triangle, std::size_t number) {
  Triangle sorted = triangle;
  std::ranges::sort(sorted);
  const auto lowest = static_cast<std::size_t>(std::ranges::min_element(triangle) - triangle.begin());
  return {sorted, triangle[(lowest + 1) % 3] < triangle[(lowest + 2) % 3], number};
}

/// \param cancel  whether two triangles with opposite sides are both removed, or one stays
std::vector<Triangle> without_doubles(const std::vector<Triangle>& triangles, bool cancel) {
  std::vector<Facing> list;
  list.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) list.push_back(facing(triangles[t], t));
  std::ranges::sort(list, {}, [](const Facing& f) { return std::pair(f.sorted, f.number); });
  std::vector<bool> stays(triangles.size(), false);
  for (std::size_t begin = 0; begin < list.size();) {
    std::size_t end = begin;
    std::int64_t sum = 0;
    for (; end < list.size() && list[end].sorted == list[begin].sorted; ++end)
      sum += list[end].ascends ? 1 : -1;
    for (std::size_t i = begin; i < end; ++i) {
      if (sum == 0 ? cancel : list[i].ascends != (sum > 0)) continue;
      stays[list[i].number] = true;
      break;
    }
    begin = end;
  }
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (stays[t]) kept.push_back(triangles[t]);
  }
  return kept;
}

}  // namespace

Surface surface_of(PolygonFile file) {
  const std::vector<Index> first = first_at_place(file.points);
  std::vector<Triangle> triangles;
  for (std::vector<Index>& polygon : file.polygons) {
    for (Index& corner : polygon) corner = at(first, corner);
    polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
    while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
    if (polygon.size() >= 3) append_triangles(file.points, polygon, triangles);
  }
  std::erase_if(triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  Surface surface{std::move(file.points), without_doubles(triangles, true)};
  if (surface.triangles.empty()) surface.triangles = without_doubles(triangles, false);
  return surface;
}

std::string place_text(const Vec3& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x, p.y, p.z);
}

}  // namespace palpate::app
