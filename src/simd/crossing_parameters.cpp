#include "simd/crossing_parameters.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/crossing_parameters.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/vector_gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

struct Filtered {
  Double value;
  Double error;
};

/// orient3d() from two sides u and v of a triangle and the vector w from the same corner to a point, with the
/// same order of operations.
HWY_INLINE Filtered orientation(const Vector& u, const Vector& v, const Vector& w) {
  const Double vxwy = hn::Mul(v.x, w.y);
  const Double vywx = hn::Mul(v.y, w.x);
  const Double wxuy = hn::Mul(w.x, u.y);
  const Double wyux = hn::Mul(w.y, u.x);
  const Double uxvy = hn::Mul(u.x, v.y);
  const Double uyvx = hn::Mul(u.y, v.x);
  const Double value = hn::Add(hn::Add(hn::Mul(u.z, hn::Sub(vxwy, vywx)), hn::Mul(v.z, hn::Sub(wxuy, wyux))),
                               hn::Mul(w.z, hn::Sub(uxvy, uyvx)));
  const Double uz = hn::Abs(u.z);
  const Double vz = hn::Abs(v.z);
  const Double wz = hn::Abs(w.z);
  const auto sizes = [](Double a, Double b) { return hn::Add(hn::Abs(a), hn::Abs(b)); };
  const Double permanent = hn::Add(hn::Add(hn::Mul(uz, sizes(vxwy, vywx)), hn::Mul(vz, sizes(wxuy, wyux))),
                                   hn::Mul(wz, sizes(uxvy, uyvx)));
  const Double underflow = hn::Mul(hn::Set(doubles, OrientationBound::tiny),
                                   hn::Add(hn::Add(hn::Add(hn::Set(doubles, 4.0), uz), vz), wz));
  return {value, hn::Add(hn::Mul(hn::Set(doubles, OrientationBound::relative), permanent), underflow)};
}

struct Meeting {
  Double parameter;  ///< -1 where double precision cannot decide
  Double passage;
};

/// \param corner  function: corner k of the triangles
/// \param end     function: end k of the segments
template <class Corner, class End>
HWY_INLINE Meeting meeting(const Corner& corner, const End& end) {
  const Double zero = hn::Zero(doubles);
  const Double one = hn::Set(doubles, 1.0);
  const Vector t0 = corner(0);
  const Vector u = difference(corner(1), t0);
  const Vector v = difference(corner(2), t0);
  const Filtered a = orientation(u, v, difference(end(0), t0));
  const Filtered b = orientation(u, v, difference(end(1), t0));
  const auto tells = [&](const Filtered& f) HWY_ATTR {
    return hn::Lt(f.error, hn::Mul(hn::Set(doubles, parameter_accuracy), hn::Abs(f.value)));
  };
  const Double passage = hn::Sub(a.value, b.value);
  const Double ratio = hn::Div(a.value, passage);
  const Double clamped =
      hn::IfThenElse(hn::Lt(ratio, zero), zero, hn::IfThenElse(hn::Lt(one, ratio), one, ratio));
  return {hn::IfThenElse(hn::And(tells(a), tells(b)), clamped, hn::Set(doubles, -1.0)), passage};
}

}  // namespace

void find_parameters(const Vec3* positions, SegmentsInTriangles& segments, std::size_t size) {
  for (std::size_t lane = 0; lane < size; lane += double_lanes) {
    const auto load_at = [&](const SegmentsInTriangles::Points& points)
                             HWY_ATTR { return load_points(doubles, positions, &points[lane]); };
    const Meeting found = meeting([&](std::size_t k) HWY_ATTR { return load_at(segments.corner[k]); },
                                  [&](std::size_t k) HWY_ATTR { return load_at(segments.end[k]); });
    store(found.parameter, segments.parameter, lane);
    store(found.passage, segments.passage, lane);
  }
}

bool find_parameters_of(const CrossedTriangles& all, std::span<Crossing> crossings) {
  const Vec3* positions = all.positions.data();
  const Index* points = all.point_of_contact.data();
  const BorderEdge* edges = all.edges.data();
  const Triangle* triangles = all.triangles.data();
  Double least = hn::Zero(doubles);
  for_each_block(crossings.size(), [&](const auto& block) HWY_ATTR {
    std::array<const BorderEdge*, double_lanes> edge;
    std::array<const Triangle*, double_lanes> triangle;
    for (std::size_t lane = 0; lane < double_lanes; ++lane) {
      const Crossing& crossing = crossings[block.item(lane)];
      edge[lane] = edges + crossing.border_edge;
      triangle[lane] = triangles + crossing.triangle;
    }
    const auto corner = [&](std::size_t k) HWY_ATTR {
      return load_vectors([&](std::size_t lane)
                              HWY_ATTR -> const Vec3& { return positions[(*triangle[lane])[k]]; });
    };
    const auto end = [&](std::size_t k) HWY_ATTR {
      return load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& {
        return positions[k == 0 ? points[edge[lane]->contact] : edge[lane]->free_point];
      });
    };
    const Double parameter = meeting(corner, end).parameter;
    least = hn::Min(least, parameter);
    alignas(64) double row[double_lanes];
    hn::Store(parameter, doubles, row);
    for (std::size_t lane = 0; lane < double_lanes; ++lane) crossings[block.item(lane)].parameter = row[lane];
  });
  return hn::AllFalse(doubles, hn::Lt(least, hn::Zero(doubles)));
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_parameters);
HWY_EXPORT(find_parameters_of);

void find_parameters(const Vec3* positions, SegmentsInTriangles& segments, std::size_t size) {
  HWY_DYNAMIC_DISPATCH(find_parameters)(positions, segments, size);
}

bool find_parameters(const CrossedTriangles& all, std::span<Crossing> crossings) {
  return HWY_DYNAMIC_DISPATCH(find_parameters_of)(all, crossings);
}

}  // namespace palpate::simd
#endif
