#include "embree_query.hpp"

#include <cmath>
#include <embree3/rtcore.h>
#include <limits>
#include <stdexcept>

#include "contact/layers.hpp"
#include "geometry/box.hpp"
#include "geometry/predicates.hpp"

namespace palpate::bench {
namespace {

float below(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float above(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace

std::string EmbreeMode::name() const {
  const char* const names[] = {"rebuild low", "rebuild medium", "refit"};
  return std::string(names[static_cast<int>(update)]) + (per_body ? ", per body" : ", one scene");
}

std::vector<EmbreeMode> every_embree_mode() {
  std::vector<EmbreeMode> modes;
  for (const bool per_body : {false, true})
    for (const auto update :
         {EmbreeMode::Update::rebuild_low, EmbreeMode::Update::rebuild_medium, EmbreeMode::Update::refit})
      modes.push_back({update, per_body});
  return modes;
}

struct EmbreeQuery::State {
  /// Points or tets of one body, or of all.
  struct Part {
    const State* state = nullptr;
    bool points = false;
    Range range;
    RTCScene scene = nullptr;
    RTCGeometry geometry = nullptr;
  };

  State(const Bodies& b, const PairFilter& filter, const EmbreeMode& m)
      : bodies(b), may_touch(filter), mode(m), device(rtcNewDevice("threads=1,set_affinity=0")) {
    if (device == nullptr) throw std::runtime_error("Embree gives no device");
    const auto n = static_cast<std::size_t>(m.per_body ? bodies.body_count() : 1);
    parts.resize(2 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const Body& body = bodies.bodies()[i];
      const Range all_points{0, static_cast<Index>(bodies.points_rest().size())};
      const Range all_tets{0, static_cast<Index>(bodies.tets().size())};
      make(parts[2 * i], true, m.per_body ? body.points : all_points);
      make(parts[2 * i + 1], false, m.per_body ? body.tets : all_tets);
    }
  }
  ~State() {
    for (const Part& part : parts) {
      rtcReleaseGeometry(part.geometry);
      rtcReleaseScene(part.scene);
    }
    rtcReleaseDevice(device);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void make(Part& part, bool points, Range range) {
    part = {this, points, range, rtcNewScene(device), rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER)};
    rtcSetGeometryUserPrimitiveCount(part.geometry, static_cast<unsigned>(range.size()));
    rtcSetGeometryUserData(part.geometry, &part);
    rtcSetGeometryBoundsFunction(part.geometry, &State::bounds, nullptr);
    const RTCBuildQuality quality = mode.update == EmbreeMode::Update::rebuild_low ? RTC_BUILD_QUALITY_LOW
                                    : mode.update == EmbreeMode::Update::refit     ? RTC_BUILD_QUALITY_REFIT
                                                                                   : RTC_BUILD_QUALITY_MEDIUM;
    rtcSetGeometryBuildQuality(part.geometry, quality);
    rtcSetSceneBuildQuality(part.scene, mode.update == EmbreeMode::Update::rebuild_medium
                                            ? RTC_BUILD_QUALITY_MEDIUM
                                            : RTC_BUILD_QUALITY_LOW);
    rtcSetSceneFlags(part.scene, RTC_SCENE_FLAG_DYNAMIC);
    rtcAttachGeometry(part.scene, part.geometry);
  }

  static void bounds(const RTCBoundsFunctionArguments* a) {
    const Part& part = *static_cast<const Part*>(a->geometryUserPtr);
    const auto i = part.range.begin + static_cast<Index>(a->primID);
    const std::span<const Vec3> x = part.state->positions;
    const Box box = part.points ? Box{at(x, i), at(x, i)} : box_of(x, at(part.state->bodies.tets(), i));
    *a->bounds_o = {below(box.lower.x), below(box.lower.y), below(box.lower.z), 0.0F,
                    above(box.upper.x), above(box.upper.y), above(box.upper.z), 0.0F};
  }

  struct Pair {
    State* state;
    Index first_point;
    Index first_tet;
  };

  static void collide(void* user, RTCCollision* collisions, unsigned count) {
    const Pair& pair = *static_cast<const Pair*>(user);
    for (unsigned i = 0; i < count; ++i)
      pair.state->test({pair.first_point + static_cast<Index>(collisions[i].primID0),
                        pair.first_tet + static_cast<Index>(collisions[i].primID1)});
  }

  void test(const PointInTet& pair) {
    const Tet& tet = at(bodies.tets(), pair.tet);
    const Index own = at(bodies.body_of_point(), pair.point);
    const Index body = bodies.body_of(tet);
    if (!may_touch(own, body, pair.point, tet)) return;
    const Vec3& x = at(positions, pair.point);
    if (!box_of(positions, tet).contains(x) || !point_in_tet(x, at(positions, tet[0]), at(positions, tet[1]),
                                                             at(positions, tet[2]), at(positions, tet[3])))
      return;
    if (own == body && is_fold(bodies, positions, pair.point, pair.tet)) return;
    found.push_back(pair);
  }

  void update() {
    for (const Part& part : parts) {
      rtcCommitGeometry(part.geometry);
      rtcCommitScene(part.scene);
    }
  }

  void search() {
    for (std::size_t i = 0; i < parts.size(); i += 2) {
      for (std::size_t j = 1; j < parts.size(); j += 2) {
        if (mode.per_body && !may_meet(i, j)) continue;
        Pair pair{this, parts[i].range.begin, parts[j].range.begin};
        rtcCollide(parts[i].scene, parts[j].scene, &State::collide, &pair);
      }
    }
  }
  /// By the boxes of the bodies, and whether they may touch at all.
  bool may_meet(std::size_t i, std::size_t j) const {
    if (i + 1 == j && may_touch.self_collision[i / 2] == 0) return false;
    RTCBounds a;
    RTCBounds b;
    rtcGetSceneBounds(parts[i].scene, &a);
    rtcGetSceneBounds(parts[j].scene, &b);
    return a.lower_x <= b.upper_x && b.lower_x <= a.upper_x && a.lower_y <= b.upper_y &&
           b.lower_y <= a.upper_y && a.lower_z <= b.upper_z && b.lower_z <= a.upper_z;
  }

  const Bodies& bodies;
  PairFilter may_touch;
  EmbreeMode mode;
  RTCDevice device;
  std::vector<Part> parts;
  std::span<const Vec3> positions;
  std::vector<PointInTet> found;
};

EmbreeQuery::EmbreeQuery(const Bodies& bodies, const PairFilter& may_touch, const EmbreeMode& mode)
    : state_(std::make_unique<State>(bodies, may_touch, mode)) {}
EmbreeQuery::~EmbreeQuery() = default;

std::span<const PointInTet> EmbreeQuery::find(std::span<const Vec3> positions) {
  state_->positions = positions;
  state_->found.clear();
  state_->update();
  state_->search();
  return state_->found;
}

}  // namespace palpate::bench
