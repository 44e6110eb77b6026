#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <bit>
#include <cstdint>

#include "peers/float_box.hpp"
#include "peers/timed_peer.hpp"

namespace palpate::bench {
namespace {

btDbvtVolume volume_of(const Box& box) {
  return btDbvtVolume::FromMM(btVector3(below(box.lower.x), below(box.lower.y), below(box.lower.z)),
                              btVector3(above(box.upper.x), above(box.upper.y), above(box.upper.z)));
}
void* as_pointer(Index i) {
  return std::bit_cast<void*>(static_cast<std::intptr_t>(i));
}
Index as_index(const btDbvtNode* leaf) {
  return static_cast<Index>(std::bit_cast<std::intptr_t>(leaf->data));
}

/// Bullet's dynamic trees of boxes: leaves are updated in each frame. One tree against another, or one
/// primitive after the other against a tree. Bullet has no threads for that.
class BulletPeer : public TimedPeer {
 public:
  BulletPeer(const Course& course, Grouping grouping, bool trees)
      : TimedPeer(course, grouping), trees_(trees), first_(problem().groups()), second_(problem().groups()) {}

 protected:
  void search() override {
    for (std::size_t g = 0; g < problem().groups(); ++g) {
      update_second(g);
      if (trees_) update_first(g);
    }
    for (std::size_t i = 0; i < problem().groups(); ++i)
      for (std::size_t j = 0; j < problem().groups(); ++j)
        if (problem().may_meet(i, j)) collide(i, j);
  }

 private:
  struct Tree {
    btDbvt tree;
    std::vector<btDbvtNode*> leaves;
  };
  struct Policy : btDbvt::ICollide {
    explicit Policy(BulletPeer& p) : peer(&p) {}
    void Process(const btDbvtNode* a, const btDbvtNode* b) override {
      peer->propose(as_index(a), as_index(b));
    }
    void Process(const btDbvtNode* leaf) override { peer->propose(first, as_index(leaf)); }
    BulletPeer* peer;
    Index first = 0;
  };

  /// Leaves of the same primitives are updated; a tree of other primitives, such as border edges, is rebuilt.
  template <class PrimitiveOf, class BoxOf>
  static void update(Tree& tree, std::size_t count, bool rebuild, PrimitiveOf&& primitive, BoxOf&& box) {
    if (rebuild || tree.leaves.size() != count) {
      tree.tree.clear();
      tree.leaves.clear();
      for (std::size_t i = 0; i < count; ++i)
        tree.leaves.push_back(tree.tree.insert(volume_of(box(primitive(i))), as_pointer(primitive(i))));
      if (!rebuild) tree.tree.optimizeTopDown();
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      btDbvtVolume volume = volume_of(box(primitive(i)));
      tree.tree.update(tree.leaves[i], volume);
    }
  }
  void update_first(std::size_t g) {
    const std::span<const Index> list = problem().first(g);
    update(
        first_[g], list.size(), problem().task() == Task::edges_on_triangles,
        [&](std::size_t i) { return list[i]; }, [&](Index i) { return problem().first_box(i); });
  }
  void update_second(std::size_t g) {
    const Range range = problem().second(g);
    update(
        second_[g], static_cast<std::size_t>(range.size()), false,
        [&](std::size_t i) { return range.begin + static_cast<Index>(i); },
        [&](Index i) { return problem().second_box(i); });
  }

  void collide(std::size_t i, std::size_t j) {
    Policy policy(*this);
    btDbvt& second = second_[j].tree;
    if (trees_) {
      second.collideTTpersistentStack(first_[i].tree.m_root, second.m_root, policy);
      return;
    }
    for (const Index primitive : problem().first(i)) {
      policy.first = primitive;
      second.collideTVNoStackAlloc(second.m_root, volume_of(problem().first_box(primitive)), stack_, policy);
    }
  }

  bool trees_;
  std::vector<Tree> first_;
  std::vector<Tree> second_;
  btNodeStack stack_;
};

}  // namespace

void add_bullet(const Course& course, std::vector<Entrant>& entrants) {
  Entrant entrant{"Bullet btDbvt", 1, Answer::exact, {}};
  for (const Grouping grouping : {Grouping::one, Grouping::per_body}) {
    for (const bool trees : {false, true}) {
      const std::string name = std::string(trees ? "tree against tree" : "primitive by primitive") +
                               (grouping == Grouping::one ? ", one tree" : ", per body");
      entrant.modes.push_back({name, [&course, grouping, trees] {
                                 return std::make_unique<BulletPeer>(course, grouping, trees);
                               }});
    }
  }
  entrants.push_back(std::move(entrant));
}

}  // namespace palpate::bench
