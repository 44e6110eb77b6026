#include "contact/edge_query.hpp"

#include <algorithm>

#include "contact/rim_falloff.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"
#include "room.hpp"
#include "simd/separations.hpp"

namespace palpate {
namespace {

constexpr std::size_t clusters_of_chunk = 64;
constexpr std::size_t groups_of_chunk = 64;
/// Number of detections like the last one for which a list has a margin, and the largest margin, over the
/// reach of a rim.
constexpr double detections = 12.0;
constexpr double most_room = 0.4;
constexpr double least_room = 1e-3;
/// Least number of detections that the margin must cover; faster pairs are listed each time.
constexpr double fewest_detections = 3.0;
/// Number of lists without a margin after a margin that did not pay; four times as many each time.
constexpr int shortest_patience = 8;
constexpr int longest_patience = 2048;
/// Smaller distances are not cached, m; floats can still represent them.
constexpr double least_apart = 1e-30;
constexpr double most_apart = 1e38;
/// Factor above the rounding error of the sum of a few numbers.
constexpr double rounding = 1.0 + 1e-12;

}  // namespace

struct EdgeQuery::Frame {
  const parallel::Threads& threads;
  const Bodies& bodies;
  std::span<const Vec3> positions;
  const PairFilter& may_touch;
  const ContactTable& contacts;
};

EdgeQuery::EdgeQuery(const Bodies& bodies)
    : search_(bodies),
      boxes_(search_.clusters().clusters.size()),
      motions_(boxes_.size()),
      bodies_(bodies.bodies().size()),
      grown_(bodies.bodies().size(), 0.0) {
  for (Index b = 0; b < bodies.body_count(); ++b) most_room_.push_back(most_room * rim_reach(bodies, b));
}

/// Updates boxes and motions of clusters and bodies.
void EdgeQuery::follow(const Frame& frame) {
  if (last_.empty()) last_.assign(frame.positions.begin(), frame.positions.end());
  const Clusters& clusters = search_.clusters();
  parallel::for_each(frame.threads, boxes_.size(), clusters_of_chunk, [&](std::size_t c) {
    Box box;
    Box motion;
    for (const Index p : clusters.points_of(clusters.clusters[c])) {
      const Vec3& x = at(frame.positions, p);
      box.extend(x);
      motion.extend(x - at(last_, p));
    }
    boxes_[c] = box;
    motions_[c] = motion;
  });
  std::ranges::copy(frame.positions, last_.begin());
  std::ranges::fill(bodies_, Motion{});
  for (std::size_t c = 0; c < boxes_.size(); ++c) {
    Motion& body = at(bodies_, clusters.clusters[c].body);
    body.box.extend(boxes_[c]);
    body.motion.extend(motions_[c]);
  }
}

/// Finds pairs of bodies whose boxes meet and that may touch; existing pairs keep their lists.
void EdgeQuery::pair_bodies(const Frame& frame) {
  body_order_.clear();
  make_room(body_order_, bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    body_order_.emplace_back(bodies_[b].box.lower.x, static_cast<Index>(b));
  std::ranges::sort(body_order_);
  body_pairs_.clear();
  for (std::size_t i = 0; i < body_order_.size(); ++i) {
    const Index a = body_order_[i].second;
    const Box& box = at(bodies_, a).box;
    for (std::size_t j = i + 1; j < body_order_.size() && body_order_[j].first <= box.upper.x; ++j) {
      const Index b = body_order_[j].second;
      if (!box.overlaps(at(bodies_, b).box) || !frame.may_touch.bodies(a, b)) continue;
      make_room(body_pairs_, body_pairs_.size() + 1);
      body_pairs_.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::ranges::sort(body_pairs_);
  next_.clear();
  make_room(next_, body_pairs_.size());
  for (const EdgeSearch::Pair& pair : body_pairs_) {
    const auto known = std::ranges::lower_bound(pairs_, pair, {}, &NearPair::bodies);
    if (known != pairs_.end() && known->bodies == pair) {
      next_.push_back(std::move(*known));
    } else {
      next_.emplace_back().bodies = pair;
    }
    NearPair& now = next_.back();
    const double last = furthest(at(bodies_, pair.first).motion, at(bodies_, pair.second).motion);
    now.usual = std::max(last, 0.5 * now.usual);
    now.moved = rounding * (now.moved + last);
  }
  pairs_.swap(next_);
}

/// Plans the next list of a pair from its last one.
double EdgeQuery::room_for(NearPair& pair) const {
  if (pair.room > 0.0) {
    const bool paid = pair.near.size() <= pair.served * pair.bare;
    pair.patience = paid ? shortest_patience : std::min(4 * pair.patience, longest_patience);
    pair.left_bare = paid ? 0 : pair.patience;
  }
  if (pair.room == 0.0) pair.bare = pair.near.size();
  const double most = at(most_room_, pair.bodies.first) + at(most_room_, pair.bodies.second);
  if (pair.left_bare > 0 || fewest_detections * pair.usual > most) {
    pair.left_bare = std::max(0, pair.left_bare - 1);
    return 0.0;
  }
  return std::clamp(detections * pair.usual, least_room * most, most);
}

/// Renews the lists of pairs that have moved further than their margin.
void EdgeQuery::list_again(const Frame& frame) {
  body_pairs_.clear();
  make_room(body_pairs_, pairs_.size());
  std::ranges::fill(grown_, 0.0);
  for (NearPair& pair : pairs_) {
    ++pair.served;
    if (pair.moved <= pair.room) continue;
    body_pairs_.push_back(pair.bodies);
    pair.room = room_for(pair);
    for (const Index body : {pair.bodies.first, pair.bodies.second})
      at(grown_, body) = std::max(at(grown_, body), 0.5 * pair.room);
    pair.moved = 0.0;
    pair.served = 0;
    pair.groups.clear();
    pair.near.clear();
    pair.apart.clear();
  }
  if (body_pairs_.empty()) return;
  search_.find(frame.threads, frame.bodies, frame.positions, boxes_, body_pairs_, grown_);
  add_to_lists();
}

void EdgeQuery::add_to_lists() {
  auto next = search_.found().begin();
  for (const auto& [clusters, size] : search_.groups()) {
    if (size == 0) continue;
    const Index a = at(search_.clusters().clusters, clusters.first).body;
    const Index b = at(search_.clusters().clusters, clusters.second).body;
    NearPair& pair = *std::ranges::lower_bound(pairs_, EdgeSearch::Pair(std::min(a, b), std::max(a, b)), {},
                                               &NearPair::bodies);
    make_room(pair.groups, pair.groups.size() + 1);
    make_room(pair.near, pair.near.size() + size);
    make_room(pair.apart, pair.apart.size() + size);
    pair.groups.push_back({clusters, pair.near.size(), size, 0.0});
    const auto end = next + static_cast<std::ptrdiff_t>(size);
    pair.near.insert(pair.near.end(), next, end);
    pair.apart.insert(pair.apart.end(), size, -1.0F);
    next = end;
  }
}

/// Edges and triangles that are tested together.
class EdgeQuery::Batch {
 public:
  Batch(const Frame& frame, std::vector<EdgeTriangle>& found) : frame_(frame), found_(found) {}

  /// \param moved  motion of the group
  /// \param apart  distance of the pair, as a result
  void add(const EdgeTriangle& pair, double moved, float& apart) {
    const Edge& edge = at(frame_.bodies.edges(), pair.edge);
    const Triangle& triangle = at(frame_.bodies.triangles(), pair.triangle);
    for (std::size_t i = 0; i < 2; ++i) rows_.end[i].put(at(frame_.positions, edge[i]), size_);
    for (std::size_t i = 0; i < 3; ++i) rows_.corner[i].put(at(frame_.positions, triangle[i]), size_);
    waiting_[size_] = {pair, moved, &apart};
    if (++size_ == rows_.most) test();
  }
  void test() {
    if (size_ == 0) return;
    simd::find_separations(rows_, size_);
    for (std::size_t i = 0; i < size_; ++i) {
      const Waiting& pair = waiting_[i];
      constexpr double down = 1.0 - 1e-6;
      if (rows_.apart[i] > least_apart) {
        *pair.apart = static_cast<float>(std::min(down * (pair.moved + rows_.apart[i]), most_apart));
      } else {
        test(pair.pair);
      }
    }
    size_ = 0;
  }

 private:
  void test(const EdgeTriangle& pair) {
    const Edge& edge = at(frame_.bodies.edges(), pair.edge);
    const Triangle& t = at(frame_.bodies.triangles(), pair.triangle);
    const std::array<Vec3, 3> x = corners_of(frame_.positions, t);
    if (!segment_meets_triangle(at(frame_.positions, edge[0]), at(frame_.positions, edge[1]), x[0], x[1],
                                x[2]))
      return;
    const Index body = frame_.bodies.body_of(t);
    if (frame_.contacts.find(edge[0], body) < 0 && frame_.contacts.find(edge[1], body) < 0)
      found_.push_back(pair);
  }

  struct Waiting {
    EdgeTriangle pair;
    double moved;
    float* apart;
  };
  const Frame& frame_;
  std::vector<EdgeTriangle>& found_;
  simd::SegmentsAndTriangles rows_;
  std::array<Waiting, simd::SegmentsAndTriangles::most> waiting_;
  std::size_t size_ = 0;
};

void EdgeQuery::test(NearPair& pair, std::size_t number, Batch& batch) const {
  Group& group = pair.groups[number];
  const auto& [a, b] = group.clusters;
  // Pairs that were listed now have not moved since.
  if (pair.moved > 0.0) group.moved = rounding * (group.moved + furthest(at(motions_, a), at(motions_, b)));
  for (std::size_t i = group.begin; i < group.begin + group.size; ++i) {
    if (!(group.moved <= static_cast<double>(pair.apart[i])))
      batch.add(pair.near[i], group.moved, pair.apart[i]);
  }
}

void EdgeQuery::find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const PairFilter& may_touch, const ContactTable& contacts) {
  const Frame frame{threads, bodies, positions, may_touch, contacts};
  follow(frame);
  pair_bodies(frame);
  list_again(frame);
  begin_.clear();
  make_room(begin_, pairs_.size() + 1);
  begin_.push_back(0);
  for (const NearPair& pair : pairs_) begin_.push_back(begin_.back() + pair.groups.size());
  const std::size_t chunks = parallel::chunk_count(begin_.back(), groups_of_chunk);
  lists_.make_room_in_all(chunks + chunks / 2 + 1, 4 * groups_of_chunk);
  lists_.fill(threads, begin_.back(), groups_of_chunk,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeTriangle>& found) {
                Batch batch(frame, found);
                auto pair =
                    static_cast<std::size_t>(std::ranges::upper_bound(begin_, begin) - begin_.begin()) - 1;
                for (std::size_t group = begin; group < end; ++group) {
                  while (group >= begin_[pair + 1]) ++pair;
                  test(pairs_[pair], group - begin_[pair], batch);
                }
                batch.test();
              });
  make_room(found_, contacts.size());
  lists_.join(found_);
  std::ranges::sort(found_, {}, [](const EdgeTriangle& hit) { return std::pair(hit.edge, hit.triangle); });
}

}  // namespace palpate
