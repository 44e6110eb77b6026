#include "contact/clustered_crossings.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>

#include "geometry/predicates.hpp"
#include "room.hpp"

namespace palpate {

using simd::EdgeStar;
using simd::FixedBox;
using simd::FixedPoint;
using simd::StarHits;

namespace {

/// Border edges of a chunk.
constexpr std::size_t crossing_grain = 512;
/// A star with edges longer than so many triangles is searched edge by edge, in pieces of that length.
constexpr std::int32_t long_star = 4;
constexpr std::int32_t most_pieces = 64;
/// By how much the box of a piece grows: positions and ends of pieces are rounded.
constexpr std::int32_t piece_margin = 3;
/// In wanted_.
constexpr std::uint8_t has_crossing = 2;

/// The box of piece i of n of a segment.
FixedBox box_of_piece(const FixedPoint& a, const FixedPoint& b, std::int32_t i, std::int32_t n) {
  const auto along = [&](std::int32_t from, std::int32_t to) {
    const auto place = [&](std::int64_t k) {
      return from + static_cast<std::int32_t>((std::int64_t{to} - from) * k / n);
    };
    const auto [lower, upper] = std::minmax({place(i), place(i + 1)});
    return std::pair(std::max(0, lower - piece_margin), upper + piece_margin);
  };
  const auto x = along(a.x, b.x);
  const auto y = along(a.y, b.y);
  const auto z = along(a.z, b.z);
  return {{x.first, y.first, z.first, 0}, {x.second, y.second, z.second, 0}};
}

/// Sorts pairs that are few, and nearly in order, most often.
void sort_few(std::span<EdgeInTriangle> pairs) {
  constexpr std::size_t few = 32;
  if (pairs.size() > few) return std::sort(pairs.begin(), pairs.end());
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const EdgeInTriangle pair = pairs[i];
    std::size_t place = i;
    for (; place > 0 && pair < pairs[place - 1]; --place) pairs[place] = pairs[place - 1];
    pairs[place] = pair;
  }
}

}  // namespace

/// Input of find() that all chunks use.
struct ClusteredCrossings::Problem {
  const Frame& frame;
  BorderEdgeView border;
  std::span<const FixedPoint> points;
};

/// Searches the stars of a chunk of border edges.
class ClusteredCrossings::Work {
 public:
  /// \param wanted  (n_clusters) 0: left out; empty: none is
  Work(const TriangleTree& tree, const Problem& problem, std::span<const std::uint8_t> wanted)
      : tree_(tree), problem_(problem), wanted_(wanted), points_(problem.points.data()) {}

  /// Appends what it finds, in order.
  QueryTally find(std::size_t begin, std::size_t end, std::vector<EdgeInTriangle>& found) {
    QueryTally tally;
    for_each_star(begin, end, [&] {
      const std::size_t first = found.size();
      search([&](std::span<const std::int32_t> leaves, std::span<std::int32_t> entries) {
        tally.candidates += star_.size * entries.size();
        test(leaves, entries, found);
      });
      put_in_order(found, first);
    });
    return tally;
  }
  /// Adds the number of tests for each cluster. Chunks may do so at the same time: sums of integers do not
  /// depend on their order.
  void count(std::size_t begin, std::size_t end, std::span<std::size_t> tests) {
    for_each_star(begin, end, [&] {
      search([&](std::span<const std::int32_t> /*leaves*/, std::span<std::int32_t> entries) {
        for (const std::int32_t entry : entries) {
          std::atomic_ref tests_of_leaf(at(tests, TriangleTree::leaf_of(entry)));
          tests_of_leaf.fetch_add(star_.size, std::memory_order_relaxed);
        }
      });
    });
  }

 private:
  /// Calls use() for the edges of each contact, at most EdgeStar::most at a time.
  template <class Use>
  void for_each_star(std::size_t begin, std::size_t end, Use&& use) {
    const std::span<const BorderEdge> edges = problem_.border.edges();
    for (std::size_t e = begin; e < end;) {
      const Index contact = edges[e].contact;
      point_ = problem_.border.point(contact);
      body_ = problem_.border.body_of(contact);
      own_ = at(problem_.frame.bodies().body_of_point(), point_) == body_;
      first_edge_ = static_cast<Index>(e);
      star_.point = points_[point_];
      kernels_.gather_star(points_, edges.subspan(e, end - e), star_);
      const std::size_t size = star_.size;
      use();
      e += size;
    }
  }

  /// Calls use(leaves, entries) for parts of the tree: together they have all triangles that the star meets.
  template <class Use>
  void search(Use&& use) {
    const std::int32_t triangle = tree_.mean_extent(body_);
    in_pieces_ = star_.reach / long_star > triangle;
    if (!in_pieces_) return search_box(star_.box, use);
    search_pieces(1 + star_.reach / long_star / triangle, use);
  }
  /// The same for a star much longer than the triangles.
  template <class Use>
  void search_pieces(std::int32_t pieces, Use&& use) {
    const EdgeStar all = star_;
    const Index first_edge = first_edge_;
    pieces = std::min(pieces, most_pieces);
    star_.size = 1;
    for (std::size_t e = 0; e < all.size; ++e) {
      first_edge_ = first_edge + static_cast<Index>(e);
      star_.other[0] = all.other[e];
      star_.along[0] = all.along[e];
      for (std::int32_t i = 0; i < pieces; ++i)
        search_box(box_of_piece(star_.point, points_[star_.other[0]], i, pieces), use);
    }
  }
  template <class Use>
  void search_box(const FixedBox& box, Use&& use) {
    tree_.for_each_leaf(kernels_, body_, box, [&](std::span<const std::int32_t> leaves) {
      std::array<std::int32_t, TriangleTree::most_nodes> kept;
      if (!wanted_.empty()) leaves = keep_wanted(leaves, kept);
      TriangleTree::Children entries;
      const std::span<std::int32_t> near = tree_.list_entries(kernels_, leaves, box, entries);
      if (!near.empty()) use(leaves, near);
    });
  }

  [[nodiscard]] std::span<const std::int32_t> keep_wanted(std::span<const std::int32_t> leaves,
                                                          std::span<std::int32_t> kept) const {
    const auto end = std::ranges::copy_if(leaves, kept.begin(), [&](std::int32_t leaf) {
                       return at(wanted_, leaf) != 0;
                     }).out;
    return {kept.begin(), end};
  }

  void test(std::span<const std::int32_t> leaves, std::span<std::int32_t> entries,
            std::vector<EdgeInTriangle>& found) {
    std::int32_t extent = 0;
    for (const std::int32_t leaf : leaves) extent = std::max(extent, tree_.extent(leaf));
    const auto reach = static_cast<float>(star_.reach) + static_cast<float>(extent + piece_margin + 1);
    StarHits hits;
    kernels_.test_star(points_, tree_.triangles(), entries, star_, reach, hits);
    const float bound = hits.bound;
    const float enough = own_ ? std::numeric_limits<float>::infinity() : bound;
    const float* least = hits.least.data();
    const Index* const triangles = tree_.triangles()->triangle.data();
    const Index first_edge = first_edge_;
    for (const StarHits::Hit& hit : std::span(hits.hit).first(hits.size)) {
      const std::int32_t* const of_hit = entries.data() + hit.place / EdgeStar::most;
      std::uint32_t left = hit.lanes;
      do {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        const std::uint32_t edge = hit.place % EdgeStar::most;
        const Index triangle = triangles[of_hit[lane]];
        if (least[lane] > enough || meets(star_.other[edge], triangle, least[lane] > bound))
          found.push_back({triangle, first_edge + static_cast<Index>(edge)});
        left &= left - 1;
      } while (left != 0);
      least += hits.lanes;
    }
  }

  [[nodiscard]] bool meets(Index other, Index number, bool surely) const {
    const Bodies& bodies = problem_.frame.bodies();
    const Triangle& triangle = at(bodies.triangles(), number);
    // Triangles of the own body at the ends of the edge meet it only at these ends.
    if (own_ &&
        std::ranges::any_of(triangle, [&](Index corner) { return corner == point_ || corner == other; }))
      return false;
    const std::span<const Vec3> x = problem_.frame.positions();
    return surely || segment_meets_triangle(at(x, point_), at(x, other), at(x, triangle[0]),
                                            at(x, triangle[1]), at(x, triangle[2]));
  }

  /// Sorts the pairs of a star.
  void put_in_order(std::vector<EdgeInTriangle>& found, std::size_t first) const {
    const auto begin = found.begin() + static_cast<std::ptrdiff_t>(first);
    sort_few(std::span(begin, found.end()));
    // Pieces of an edge may have found a pair twice.
    if (in_pieces_) found.erase(std::unique(begin, found.end()), found.end());
  }

  const simd::CrossingKernels kernels_ = simd::crossing_kernels();
  const TriangleTree& tree_;
  const Problem& problem_;
  std::span<const std::uint8_t> wanted_;
  const FixedPoint* points_;
  // The star, in part or whole:
  Index point_ = 0;
  Index body_ = 0;          ///< the penetrated body
  bool own_ = false;        ///< it is the body of the star
  bool in_pieces_ = false;  ///< the star is searched in pieces
  Index first_edge_ = 0;    ///< its border edges are numbered from this on
  EdgeStar star_;
};

void ClusteredCrossings::search(const Problem& problem) {
  const std::size_t n = problem.border.size();
  tallies_.assign(parallel::chunk_count(n, crossing_grain), {});
  lists_.fill(problem.frame.threads(), n, crossing_grain,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeInTriangle>& found) {
                Work work(tree_, problem, wanted_);
                tallies_[begin / crossing_grain] = work.find(begin, end, found);
              });
  lists_.join(problem.frame.threads(), found_);
}

void ClusteredCrossings::map_triangles(const Bodies& bodies) {
  cluster_of_.resize(bodies.triangles().size());
  for (std::size_t c = 0; c < clusters_.clusters.size(); ++c) {
    for (const Index triangle : clusters_.primitives_of(clusters_.clusters[c]))
      at(cluster_of_, triangle) = static_cast<Index>(c);
  }
}

/// Marks the clusters whose tests a limit allows, the most important ones first.
void ClusteredCrossings::choose_within(const Problem& problem, const WorkLimit& limit) {
  const std::size_t clusters = clusters_.clusters.size();
  if (cluster_of_.empty()) map_triangles(problem.frame.bodies());
  assign_with_room(costs_, clusters, std::size_t{0});
  assign_with_room(wanted_, clusters, std::uint8_t{0});
  parallel::for_chunks(problem.frame.threads(), problem.border.size(), crossing_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         Work work(tree_, problem, {});
                         work.count(begin, end, costs_);
                       });
  queue_.arrange(clusters_, problem.frame.positions(), limit.region,
                 [&](const Cluster& cluster) { return at(penetrated_, cluster.body) != 0; });
  run_.run(
      problem.frame.threads(), queue_, limit.allowance,
      [&](std::span<const Cluster> chosen, std::span<std::uint8_t> answers, std::vector<Index>& numbers) {
        QueryTally tally;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
          const Index number = number_of(chosen[i]);
          answers[i] |= ClusterQueue::asked;
          if (at(costs_, number) > 0) answers[i] |= ClusterQueue::near;
          tally.candidates += at(costs_, number);
          numbers.push_back(number);
        }
        return tally;
      });
  for (const Index number : run_.found()) at(wanted_, number) = 1;
}

/// Tells the queue which clusters have crossings.
void ClusteredCrossings::answer() {
  for (const EdgeInTriangle& pair : found_) at(wanted_, at(cluster_of_, pair.triangle)) = has_crossing;
  const std::span<const Cluster> ordered = queue_.ordered();
  for (std::size_t i = 0; i < ordered.size(); ++i)
    if (at(wanted_, number_of(ordered[i])) == has_crossing) queue_.answers()[i] |= ClusterQueue::found;
}

Index ClusteredCrossings::number_of(const Cluster& cluster) const {
  return at(cluster_of_, at(clusters_.primitives, cluster.first));
}

void ClusteredCrossings::find(const Frame& frame, const BorderEdgeView& border,
                              const std::optional<WorkLimit>& limit) {
  queue_.clear();
  is_in_cells_ = frame.fixed() == nullptr;
  if (is_in_cells_) return in_cells_.find(frame, border, limit);
  const Problem problem{frame, border, frame.fixed()->points()};
  border.mark_bodies(penetrated_, frame.bodies().bodies().size());
  tree_.fit(frame.threads(), problem.points, penetrated_);
  wanted_.clear();
  if (limit) choose_within(problem, *limit);
  search(problem);
  if (limit) answer();
}

}  // namespace palpate
