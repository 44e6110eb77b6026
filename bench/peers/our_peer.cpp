#include <palpate/detection.hpp>

#include "peers/peer.hpp"

namespace palpate::bench {
namespace {

/// The library as its users call it: the times of the phases that do the task, of a whole detection.
class OurPeer : public Peer {
 public:
  OurPeer(const Course& course, int threads)
      : task_(course.task), detector_(course.scene.bodies, settings(course), course.immovable, threads) {}

  Spent find(const Frame& frame, std::vector<Pair>& pairs) override {
    detector_.detect(frame.positions);
    pairs.clear();
    const DetectionTimes& times = detector_.times();
    if (task_ == Task::points_in_tets) {
      const Contacts& contacts = detector_.contacts();
      for (std::size_t c = 0; c < contacts.size(); ++c) pairs.push_back({contacts.point[c], contacts.tet[c]});
      return passed(times.grid + times.contacts);
    }
    for (const Crossing& crossing : detector_.crossings())
      pairs.push_back({crossing.border_edge, crossing.triangle});
    return passed(times.crossings);
  }

 private:
  static DetectionSettings settings(const Course& course) {
    DetectionSettings settings;
    settings.self_collision = course.scene.self_collision;
    settings.edge_contacts = false;  // peers are asked for points in tets and for border edges
    return settings;
  }

  /// The library's own times are of the clock; a phase is too short for them to be disturbed often.
  static Spent passed(double seconds) { return {seconds, seconds}; }

  Task task_;
  Detector detector_;
};

}  // namespace

void add_ours(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants) {
  for (const int n : threads)
    entrants.push_back({"Palpate", n, Answer::exact, {{"default", [&course, n] {
                                                         return std::make_unique<OurPeer>(course, n);
                                                       }}}});
}

}  // namespace palpate::bench
