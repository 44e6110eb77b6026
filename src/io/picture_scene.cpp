#include "io/picture_scene.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"

namespace palpate::io {
namespace {

template <class Ray>
void set_ray(Ray& ray, const Vec3& origin, const Vec3& direction, double distance) {
  ray.org_x = static_cast<float>(origin.x);
  ray.org_y = static_cast<float>(origin.y);
  ray.org_z = static_cast<float>(origin.z);
  ray.dir_x = static_cast<float>(direction.x);
  ray.dir_y = static_cast<float>(direction.y);
  ray.dir_z = static_cast<float>(direction.z);
  ray.tnear = 0.0F;
  ray.tfar = static_cast<float>(distance);
  ray.time = 0.0F;
  ray.mask = ~0U;
  ray.flags = 0;
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
  if (!device_) throw Error("picture", "", "no Embree device", "a processor that Embree supports");
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

std::optional<RayHit> RayScene::first_hit(const Vec3& origin, const Vec3& direction) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query;
  set_ray(query.ray, origin, direction, std::numeric_limits<double>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return RayHit{query.ray.tfar, static_cast<Index>(query.hit.primID), query.hit.u, query.hit.v};
}

bool RayScene::blocked(const Vec3& origin, const Vec3& direction, double distance) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray;
  set_ray(ray, origin, direction, distance);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar < 0.0F;
}

}  // namespace palpate::io
