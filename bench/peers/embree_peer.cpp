#include "peers/embree_peer.hpp"

#include <embree3/rtcore.h>
#include <stdexcept>

#include "peers/float_box.hpp"
#include "peers/timed_peer.hpp"

namespace palpate::bench {
namespace {

class EmbreePeer : public TimedPeer {
 public:
  EmbreePeer(const Course& course, const EmbreeMode& mode)
      : TimedPeer(course, mode.grouping), mode_(mode), device_(rtcNewDevice("set_affinity=0")) {
    if (device_ == nullptr) throw std::runtime_error("Embree gives no device");
    parts_.resize(2 * problem().groups());
    for (std::size_t i = 0; i < parts_.size(); ++i) make(i);
  }
  ~EmbreePeer() override {
    for (const Part& part : parts_) {
      rtcReleaseGeometry(part.geometry);
      rtcReleaseScene(part.scene);
    }
    rtcReleaseDevice(device_);
  }
  EmbreePeer(const EmbreePeer&) = delete;
  EmbreePeer& operator=(const EmbreePeer&) = delete;

 protected:
  void search() override {
    for (Part& part : parts_) commit(part);
    for (std::size_t i = 0; i < problem().groups(); ++i) {
      for (std::size_t j = 0; j < problem().groups(); ++j) {
        Both both{this, &parts_[2 * i], &parts_[2 * j + 1]};
        if (problem().may_meet(i, j) && boxes_meet(*both.first, *both.second))
          rtcCollide(both.first->scene, both.second->scene, &EmbreePeer::collide, &both);
      }
    }
  }

 private:
  /// One side of a group.
  struct Part {
    const EmbreePeer* peer = nullptr;
    std::size_t group = 0;
    bool first = false;
    RTCScene scene = nullptr;
    RTCGeometry geometry = nullptr;
    std::size_t count = 0;
  };
  struct Both {
    EmbreePeer* peer;
    const Part* first;
    const Part* second;
  };

  [[nodiscard]] std::size_t size(const Part& part) const {
    return part.first ? problem().first(part.group).size()
                      : static_cast<std::size_t>(problem().second(part.group).size());
  }
  [[nodiscard]] Index primitive(const Part& part, unsigned i) const {
    return part.first ? problem().first(part.group)[i]
                      : problem().second(part.group).begin + static_cast<Index>(i);
  }

  void make(std::size_t i) {
    Part& part = parts_[i];
    part = {this, i / 2, i % 2 == 0, rtcNewScene(device_), rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER),
            0};
    rtcSetGeometryUserData(part.geometry, &part);
    rtcSetGeometryBoundsFunction(part.geometry, &EmbreePeer::bounds, nullptr);
    // Border edges are other ones in each frame: their tree cannot be refitted.
    const bool refit = mode_.update == EmbreeMode::Update::refit &&
                       !(part.first && problem().task() == Task::edges_on_triangles);
    const bool medium = mode_.update == EmbreeMode::Update::rebuild_medium;
    rtcSetGeometryBuildQuality(part.geometry, refit    ? RTC_BUILD_QUALITY_REFIT
                                              : medium ? RTC_BUILD_QUALITY_MEDIUM
                                                       : RTC_BUILD_QUALITY_LOW);
    rtcSetSceneBuildQuality(part.scene, medium ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_LOW);
    rtcSetSceneFlags(part.scene, RTC_SCENE_FLAG_DYNAMIC);
    rtcAttachGeometry(part.scene, part.geometry);
  }

  void commit(Part& part) const {
    const std::size_t count = size(part);
    if (count != part.count) {
      rtcSetGeometryUserPrimitiveCount(part.geometry, static_cast<unsigned>(count));
      part.count = count;
    }
    rtcCommitGeometry(part.geometry);
    rtcCommitScene(part.scene);
  }

  static void bounds(const RTCBoundsFunctionArguments* a) {
    const Part& part = *static_cast<const Part*>(a->geometryUserPtr);
    const Index i = part.peer->primitive(part, a->primID);
    const Problem& problem = part.peer->problem();
    const Box box = part.first ? problem.first_box(i) : problem.second_box(i);
    *a->bounds_o = {below(box.lower.x), below(box.lower.y), below(box.lower.z), 0.0F,
                    above(box.upper.x), above(box.upper.y), above(box.upper.z), 0.0F};
  }

  static void collide(void* user, RTCCollision* collisions, unsigned count) {
    const Both& both = *static_cast<const Both*>(user);
    for (unsigned i = 0; i < count; ++i)
      both.peer->propose(both.peer->primitive(*both.first, collisions[i].primID0),
                         both.peer->primitive(*both.second, collisions[i].primID1));
  }

  static bool boxes_meet(const Part& first, const Part& second) {
    RTCBounds a;
    RTCBounds b;
    rtcGetSceneBounds(first.scene, &a);
    rtcGetSceneBounds(second.scene, &b);
    return a.lower_x <= b.upper_x && b.lower_x <= a.upper_x && a.lower_y <= b.upper_y &&
           b.lower_y <= a.upper_y && a.lower_z <= b.upper_z && b.lower_z <= a.upper_z;
  }

  EmbreeMode mode_;
  RTCDevice device_;
  std::vector<Part> parts_;
};

}  // namespace

std::string EmbreeMode::name() const {
  const char* const names[] = {"rebuild low", "rebuild medium", "refit"};
  return std::string(names[static_cast<int>(update)]) +
         (grouping == Grouping::per_body ? ", per body" : ", one scene");
}

std::vector<EmbreeMode> every_embree_mode() {
  std::vector<EmbreeMode> modes;
  for (const Grouping grouping : {Grouping::one, Grouping::per_body})
    for (const auto update :
         {EmbreeMode::Update::rebuild_low, EmbreeMode::Update::rebuild_medium, EmbreeMode::Update::refit})
      modes.push_back({update, grouping});
  return modes;
}

std::unique_ptr<Peer> make_embree_peer(const Course& course, const EmbreeMode& mode) {
  return std::make_unique<EmbreePeer>(course, mode);
}

void add_embree(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants) {
  for (const int n : threads) {
    Entrant entrant{"Embree 3", n, Answer::exact, {}};
    for (const EmbreeMode& mode : every_embree_mode())
      entrant.modes.push_back({mode.name(), [&course, mode] { return make_embree_peer(course, mode); }});
    entrants.push_back(std::move(entrant));
  }
}

}  // namespace palpate::bench
