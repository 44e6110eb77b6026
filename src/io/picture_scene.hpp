#pragma once

#include <array>
#include <cstddef>
#include <embree3/rtcore.h>
#include <memory>
#include <optional>
#include <span>

#include <palpate/types.hpp>

namespace palpate::io {

/// The first hit of a ray.
struct RayHit {
  double distance = 0.0;
  Index primitive = 0;
  double u = 0.0;  ///< barycentric weight of the second corner
  double v = 0.0;  ///< weight of the third corner
};

/// Rays that are cast together, which is faster.
struct Rays {
  static constexpr std::size_t most = 16;
  std::size_t count = 0;  ///< <= most
  std::array<Vec3, most> origins, directions;
  void add(const Vec3& origin, const Vec3& direction) {
    origins[count] = origin;
    directions[count++] = direction;
  }
};

/// Triangles or spheres for ray casting, by Embree. Queries may come from several threads at once.
class RayScene {
 public:
  /// Throws Error if Embree refuses (out of memory).
  static RayScene of_triangles(std::span<const Vec3> points, std::span<const Triangle> triangles);
  /// \param centres, radii  (n), of the same length, n > 0
  static RayScene of_spheres(std::span<const Vec3> centres, std::span<const double> radii);

  /// The first primitive that each ray meets, if any.
  [[nodiscard]] std::array<std::optional<RayHit>, Rays::most> first_hits(const Rays& rays) const;
  /// Whether each ray hits anything within `distance`.
  [[nodiscard]] std::array<bool, Rays::most> blocked(const Rays& rays, double distance) const;

 private:
  template <class Handle, void (*release)(Handle)>
  struct Release {
    using pointer = Handle;
    void operator()(Handle handle) const { release(handle); }
  };
  using Device = std::unique_ptr<RTCDevice, Release<RTCDevice, rtcReleaseDevice>>;
  using Scene = std::unique_ptr<RTCScene, Release<RTCScene, rtcReleaseScene>>;

  RayScene();
  /// Takes ownership of a geometry whose buffers are filled.
  void commit(RTCGeometry geometry);

  Device device_;
  Scene scene_;
};

}  // namespace palpate::io
