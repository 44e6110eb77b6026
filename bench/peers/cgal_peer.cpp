#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/box_intersection_d.h>
#include <array>
#include <cstddef>

#include "peers/timed_peer.hpp"

namespace palpate::bench {
namespace {

using CgalBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Index>;

/// CGAL's box_intersection_d, with the exact test as its callback.
class CgalPeer : public TimedPeer {
 public:
  CgalPeer(const Course& course, Grouping grouping, std::ptrdiff_t cutoff, bool parallel)
      : TimedPeer(course, grouping), cutoff_(cutoff), parallel_(parallel) {}

 protected:
  void search() override {
    first_.resize(problem().groups());
    second_.resize(problem().groups());
    for (std::size_t g = 0; g < problem().groups(); ++g) {
      first_[g].fill(problem().first(g).size(), [&](std::size_t i) {
        const Index primitive = problem().first(g)[i];
        return std::pair(primitive, problem().first_box(primitive));
      });
      const Range range = problem().second(g);
      second_[g].fill(static_cast<std::size_t>(range.size()), [&](std::size_t i) {
        const Index primitive = range.begin + static_cast<Index>(i);
        return std::pair(primitive, problem().second_box(primitive));
      });
    }
    for (std::size_t i = 0; i < problem().groups(); ++i)
      for (std::size_t j = 0; j < problem().groups(); ++j)
        if (problem().may_meet(i, j) && first_[i].bounds.overlaps(second_[j].bounds))
          intersect(first_[i].boxes, second_[j].boxes);
  }

 private:
  struct Side {
    std::vector<CgalBox> boxes;
    Box bounds;
    template <class BoxOf>
    void fill(std::size_t count, BoxOf&& box_of) {
      boxes.clear();
      boxes.reserve(count);
      bounds = {};
      for (std::size_t i = 0; i < count; ++i) {
        const auto& [primitive, box] = box_of(i);
        std::array<double, 3> lower{box.lower.x, box.lower.y, box.lower.z};
        std::array<double, 3> upper{box.upper.x, box.upper.y, box.upper.z};
        boxes.emplace_back(lower.data(), upper.data(), primitive);
        bounds.extend(box);
      }
    }
  };

  void intersect(std::vector<CgalBox> first, std::vector<CgalBox> second) {
    const auto found = [this](const CgalBox& a, const CgalBox& b) { propose(a.info(), b.info()); };
    constexpr auto closed = CGAL::Box_intersection_d::CLOSED;
    constexpr auto bipartite = CGAL::Box_intersection_d::BIPARTITE;
    if (parallel_) {
      CGAL::box_intersection_d<CGAL::Parallel_tag>(first.begin(), first.end(), second.begin(), second.end(),
                                                   found, cutoff_, closed, bipartite);
    } else {
      CGAL::box_intersection_d<CGAL::Sequential_tag>(first.begin(), first.end(), second.begin(), second.end(),
                                                     found, cutoff_, closed, bipartite);
    }
  }

  std::ptrdiff_t cutoff_;
  bool parallel_;
  std::vector<Side> first_;
  std::vector<Side> second_;
};

}  // namespace

void add_cgal(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants) {
  for (const int n : threads) {
    Entrant entrant{"CGAL box_intersection_d", n, Answer::exact, {}};
    for (const Grouping grouping : {Grouping::one, Grouping::per_body}) {
      for (const std::ptrdiff_t cutoff : {10, 50, 250, 1000}) {
        const std::string name =
            "cutoff " + std::to_string(cutoff) + (grouping == Grouping::one ? ", all at once" : ", per body");
        entrant.modes.push_back({name, [&course, grouping, cutoff, n] {
                                   return std::make_unique<CgalPeer>(course, grouping, cutoff, n > 1);
                                 }});
      }
    }
    entrants.push_back(std::move(entrant));
  }
}

}  // namespace palpate::bench
