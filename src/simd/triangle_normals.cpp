#include "simd/triangle_normals.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/triangle_normals.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Interpolates the corner normals of triangles at `point`. Returns the unit normals and stores them, with
/// the weights of the corners, in `points`. `point` need not be the point stored there.
HWY_INLINE Vector interpolate(const Vector& point, TrianglePoints& points, std::size_t lane) {
  const Double zero = hn::Zero(doubles);
  const Vector corner[3] = {load(points.corner[0], lane), load(points.corner[1], lane),
                            load(points.corner[2], lane)};
  const Vector area = cross(difference(corner[1], corner[0]), difference(corner[2], corner[0]));
  const Vector to[3] = {difference(corner[0], point), difference(corner[1], point),
                        difference(corner[2], point)};
  Double weight[3] = {dot(cross(to[1], to[2]), area), dot(cross(to[2], to[0]), area),
                      dot(cross(to[0], to[1]), area)};
  Double total = zero;
  for (Double& w : weight) {
    w = hn::IfThenElseZero(hn::Gt(w, zero), w);
    total = hn::Add(total, w);
  }
  const auto has_area = hn::Gt(total, zero);
  Vector mean{zero, zero, zero};
  for (std::size_t i = 0; i < 3; ++i) {
    const Double w = hn::IfThenElse(has_area, hn::Div(weight[i], total), hn::Set(doubles, 1.0 / 3.0));
    store(w, points.weight[i], lane);
    mean = sum(mean, scaled(w, load(points.corner_normal[i], lane)));
  }
  const Double length = hn::Sqrt(dot(mean, mean));
  const auto is_length =
      hn::And(hn::Gt(length, zero), hn::Le(length, hn::Set(doubles, std::numeric_limits<double>::max())));
  const Vector normal = scaled(hn::Div(hn::Set(doubles, 1.0), length), mean);
  const Vector unit{hn::IfThenElseZero(is_length, normal.x), hn::IfThenElseZero(is_length, normal.y),
                    hn::IfThenElseZero(is_length, normal.z)};
  store(unit, points.normal, lane);
  return unit;
}

void interpolate_normals(TrianglePoints& points, std::size_t size) {
  for (std::size_t lane = 0; lane < size; lane += hn::Lanes(doubles))
    interpolate(load(points.point, lane), points, lane);
}

void find_planes(CrossingEdges& edges, double lost, std::size_t size) {
  const Double one = hn::Set(doubles, 1.0);
  for (std::size_t lane = 0; lane < size; lane += hn::Lanes(doubles)) {
    const Vector from = load(edges.from, lane);
    const Vector edge = difference(load(edges.to, lane), from);
    const Double t = load(edges.parameter, lane);
    const Vector n = interpolate(sum(from, scaled(t, edge)), edges.crossing, lane);
    const Double nearest = hn::IfThenElse(hn::Lt(t, one), t, one);
    const Double weight = hn::Sub(hn::Div(one, hn::Mul(t, t)), hn::Set(doubles, lost));
    store(nearest, edges.nearest, lane);
    store(hn::Mul(nearest, hn::Sqrt(dot(edge, edge))), edges.distance, lane);
    store(weight, edges.weight, lane);
    store(hn::Mul(hn::Mul(weight, t), dot(edge, n)), edges.depth, lane);
    store(scaled(weight, n), edges.weighted, lane);
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(interpolate_normals);
HWY_EXPORT(find_planes);

void interpolate_normals(TrianglePoints& points, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(interpolate_normals)(points, size);
}

void find_planes(CrossingEdges& edges, double lost, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(find_planes)(edges, lost, size);
}

}  // namespace palpate::simd
#endif
