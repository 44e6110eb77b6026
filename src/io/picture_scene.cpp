#include "io/picture_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"

namespace palpate::io {
namespace {

/// Which rays of a packet there are: -1, otherwise 0.
using Valid = std::array<int, Rays::most>;

/// Lanes without a ray repeat the first one: Embree checks the numbers of all lanes on some processors.
void set_rays(RTCRay16& packet, Valid& valid, const Rays& rays, double distance) {
  for (std::size_t i = 0; i < Rays::most; ++i) {
    valid[i] = i < rays.count ? -1 : 0;
    const std::size_t ray = i < rays.count ? i : 0;
    packet.org_x[i] = static_cast<float>(rays.origins[ray].x);
    packet.org_y[i] = static_cast<float>(rays.origins[ray].y);
    packet.org_z[i] = static_cast<float>(rays.origins[ray].z);
    packet.dir_x[i] = static_cast<float>(rays.directions[ray].x);
    packet.dir_y[i] = static_cast<float>(rays.directions[ray].y);
    packet.dir_z[i] = static_cast<float>(rays.directions[ray].z);
    packet.tnear[i] = 0.0F;
    packet.tfar[i] = static_cast<float>(distance);
    packet.time[i] = 0.0F;
    packet.mask[i] = ~0U;
    packet.flags[i] = 0;
  }
}

template <class Item>
Item* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), count);
  if (buffer == nullptr) throw Error("picture", "", "Embree without memory for its buffers", "enough memory");
  return static_cast<Item*>(buffer);
}

using Geometry = std::unique_ptr<RTCGeometryTy, void (*)(RTCGeometry)>;

}  // namespace

// One build thread, so that the tree is the same each time, and with it the choice between two surfaces at
// the same distance.
RayScene::RayScene() : device_(rtcNewDevice("threads=1")) {
  if (!device_) {
    const bool is_unsupported = rtcGetDeviceError(nullptr) == RTC_ERROR_UNSUPPORTED_CPU;
    throw Error("picture", "", "no Embree device",
                is_unsupported ? "a processor that Embree supports" : "enough memory");
  }
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
}

void RayScene::commit(RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcCommitScene(scene_.get());
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error != RTC_ERROR_NONE) {
    throw Error("picture", "", "Embree error " + std::to_string(static_cast<int>(error)), "enough memory");
  }
}

RayScene RayScene::of_triangles(std::span<const Vec3> points, std::span<const Triangle> triangles) {
  struct Point {
    float x, y, z;
  };
  RayScene scene;
  const Geometry geometry(rtcNewGeometry(scene.device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE),
                          rtcReleaseGeometry);
  Point* out = new_buffer<Point>(geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, points.size());
  for (const Vec3& p : points)
    *out++ = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  Triangle* corners =
      new_buffer<Triangle>(geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles.size());
  for (const Triangle& triangle : triangles) *corners++ = triangle;
  scene.commit(geometry.get());
  return scene;
}

RayScene RayScene::of_spheres(std::span<const Vec3> centres, std::span<const double> radii) {
  struct Sphere {
    float x, y, z, radius;
  };
  RayScene scene;
  const Geometry geometry(rtcNewGeometry(scene.device_.get(), RTC_GEOMETRY_TYPE_SPHERE_POINT),
                          rtcReleaseGeometry);
  Sphere* out = new_buffer<Sphere>(geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, centres.size());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    *out++ = {static_cast<float>(centres[i].x), static_cast<float>(centres[i].y),
              static_cast<float>(centres[i].z), static_cast<float>(radii[i])};
  }
  scene.commit(geometry.get());
  return scene;
}

std::array<std::optional<RayHit>, Rays::most> RayScene::first_hits(const Rays& rays) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) Valid valid;
  RTCRayHit16 query;
  set_rays(query.ray, valid, rays, std::numeric_limits<double>::infinity());
  std::ranges::fill(query.hit.geomID, RTC_INVALID_GEOMETRY_ID);
  std::ranges::fill(query.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
  rtcIntersect16(valid.data(), scene_.get(), &context, &query);
  std::array<std::optional<RayHit>, Rays::most> hits;
  for (std::size_t i = 0; i < rays.count; ++i) {
    if (query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
      hits[i] = {query.ray.tfar[i], static_cast<Index>(query.hit.primID[i]), query.hit.u[i], query.hit.v[i]};
  }
  return hits;
}

std::array<bool, Rays::most> RayScene::blocked(const Rays& rays, double distance) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  alignas(64) Valid valid;
  RTCRay16 packet;
  set_rays(packet, valid, rays, distance);
  rtcOccluded16(valid.data(), scene_.get(), &context, &packet);
  std::array<bool, Rays::most> result{};
  for (std::size_t i = 0; i < rays.count; ++i) result[i] = packet.tfar[i] < 0.0F;
  return result;
}

}  // namespace palpate::io
