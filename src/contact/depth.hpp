#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_table.hpp"
#include "contact/crossings.hpp"
#include "contact/deadline.hpp"
#include "contact/edge_exit.hpp"
#include "contact/near_faces.hpp"
#include "contact/nearest_surface.hpp"
#include "contact/plane_cache.hpp"
#include "contact/plane_system.hpp"
#include "contact/surface_normals.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {

/// Consistent penetration depth and direction, for each contact; after Heidelberger, Teschner, Keiser,
/// Mueller & Gross, "Consistent penetration depth estimation for deformable collision response", 2004, made
/// continuous. docs/depth.md has the derivation, and where it is not continuous.
///
/// Each crossing x with the outward normal n of the surface there is a plane: the exit by this border edge. A
/// contact's plane is the mean of those of its border edges and of the planes of its neighbours in contact,
/// weighted by 1 / |x - p|^2 and 1 / |q - p|^2. Depth is the distance to the plane, direction its normal.
/// Deviations from the paper: it averages the neighbours breadth first, each contact once; here all contacts
/// are averages of all their neighbours at once (a linear system, with the paper's values as first guess),
/// since only this is continuous when a point enters or leaves the body. Normals turn continuously along the
/// surface. A depth is never less than the distance to the surface. Where a region has no border edge, the
/// nearest surface point is used. For deep overlaps depth and direction are consistent: the point moved along
/// its direction by its depth is outside.
class DepthEstimate {
 public:
  explicit DepthEstimate(const Bodies& bodies);

  /// Fills depth, direction and certainty of all contacts; returns how often it used a fallback (the
  /// DepthCounts). O(contacts x edges at a point x iterations + triangles + fallbacks x tets nearer than the
  /// surface), parallel. Without a deadline the bits are the same for every thread count. Past the deadline,
  /// contacts use their cached plane if there is one, means are not balanced, depths are not compared with
  /// the distance to the surface, and a depth without any plane is zero. Only contacts whose plane is
  /// computed (by `cache`) have border edges. Others have depth and direction of their cached plane, which is
  /// a given plane for their neighbours.
  DepthCounts compute(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                      ContactTable& table, const BorderEdges& border_edges, const Crossings& crossings,
                      const PlaneCache& cache = {}, const Deadline& deadline = {});
  [[nodiscard]] const SurfaceNormals& normals() const { return normals_; }
  /// How the plane of a contact was found.
  [[nodiscard]] PlaneCache::Outcome outcome(std::size_t contact) const {
    using Outcome = PlaneCache::Outcome;
    const Estimate& estimate = estimates_[contact];
    if (estimate.cached) return Outcome::cached;
    if (!estimate.rough) return Outcome::computed;
    return estimate.border_weight > 0.0 ? Outcome::propagated : Outcome::none;
  }

 private:
  static constexpr std::size_t contacts_of_search =
      NearFaces::most_points;  ///< contacts of a chunk in searches
  /// Input of one frame.
  struct Frame {
    const parallel::Threads& threads;
    const Bodies& bodies;
    std::span<const Vec3> positions;
    ContactTable& table;
    std::span<const BorderEdge> border_edges;
    const BorderEdges& links;
    const Crossings& crossings;
    const PlaneCache& cache;
    const Deadline& deadline;
  };
  /// Intermediate data of a contact. Columns of the table are written once, at the end.
  struct Estimate {
    double depth = 0.0;             ///< sum over its planes; later the depth of the first guess
    Vec3 normal;                    ///< sum of the normals of its planes; later the normal of the first guess
    Index without_crossing = 0;     ///< border edges
    double edges = 0.0;             ///< sum of 1 / length^2 of all edges of the point
    double border_edges = 0.0;      ///< sum of 1 / length^2 of the border edges with a crossing
    double border_weight = 0.0;     ///< sum of the weights of its crossings and of the surface beside it
    double crossing_weight = 0.0;   ///< sum of the weights of its crossings
    double links = 0.0;             ///< sum of the weights of its links
    double nearest_crossing = 0.0;  ///< distance
    double nearest_surface =
        0.0;                 ///< distance to the nearest surface triangle beside the point; infinite: none
    double deepest = 0.0;    ///< largest depth of the neighbours from which its first guess was propagated
    double bound = 0.0;      ///< upper bound of its depth: a neighbour's depth plus the distance to it
    double certainty = 1.0;  ///< reliability of its plane, 0 to 1
    double mean = 0.0;       ///< distance to its plane, the mean of all planes; not negative
    double agreement = 0.0;  ///< length of the normal of the mean plane
    bool fixed = false;      ///< its plane is given: that of its crossings alone, or the cached one
    std::uint8_t from_surface = 0;  ///< a Source
    bool cached = false;            ///< its plane is the cached one
    bool rough = false;             ///< there was no time to refine it
  };
  /// Sums over the border edges of a contact.
  struct BorderSums {
    std::array<double, 6> sums{};                              ///< as in WeightedPlane
    double nearest = std::numeric_limits<double>::infinity();  ///< crossing
    double edges = 0.0;  ///< sum of 1 / length^2, if that of sums is not of all edges
    bool other_edges = false;
    void add(const simd::WeightedPlane& plane) {
      nearest = std::min(nearest, plane.distance);
      for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += plane.sums[k];
    }
  };
  /// A surface triangle within reach of a contact.
  struct Beside {
    std::uint32_t search;  ///< number among those of its chunk
    double distance;
  };
  /// Scratch memory of a chunk of contacts.
  struct Scratch {
    /// Reserves enough memory for typical contacts, so that later steps allocate none.
    Scratch() {
      planes.reserve(1024);
      doubtful.reserve(1024);
      points.reserve(1024);
      beside.reserve(1024);
      normals.reserve(1024);
      contacts.reserve(contacts_of_search);
      places.reserve(contacts_of_search);
      walks.reserve(contacts_of_search);
      raise.reserve(contacts_of_search);
      searches.reserve(contacts_of_search);
    }
    ExitSearch search;
    NearFaces near;
    Index first_crossing = 0;
    bool special = false;                       ///< one of the planes is special
    std::vector<simd::WeightedPlane> planes;    ///< (n_crossings)
    std::vector<simd::Doubtful> doubtful;       ///< of the planes or normals
    std::vector<std::size_t> contacts;          ///< that search
    std::vector<Vec3> places;                   ///< (n_searches) of their points
    std::vector<NearFaces::Point> walks;        ///< (n_searches)
    std::vector<simd::PointOfTriangle> points;  ///< nearest points to contacts, on triangles in reach
    std::vector<Beside> beside;                 ///< (n_points)
    std::vector<Vec3> normals;                  ///< of an edge's crossings, later (n_points)
    std::vector<std::size_t> raise;             ///< contacts that may be nearer to the surface
    std::vector<NearFaces::Search> searches;    ///< of those
    DepthCounts counts;
    bool deep = false;       ///< one of the contacts is deep
    bool unreached = false;  ///< propagation did not reach one of the contacts
  };
  /// Gives a list at least `size` items. None is lost, and none written again.
  template <class T>
  static void grow_to(std::vector<T>& list, std::size_t size) {
    make_room(list, size);
    if (list.size() < size) list.resize(size);
  }
  /// Why depth or direction of a contact comes from the nearest surface point.
  static constexpr Index not_reached = -1;
  enum Source : std::uint8_t { from_planes, no_border, raised, cancelled };

  /// Squared length of an edge for weights; never zero, even if its points coincide.
  [[nodiscard]] double squared_distance(const Frame& frame, Index p, Index q) const {
    const double now = squared_length(at(frame.positions, q) - at(frame.positions, p));
    return now >= surely_enough_ ? now : longer_distance(frame, p, q, now);
  }
  [[nodiscard]] static double longer_distance(const Frame& frame, Index p, Index q, double now);
  void lay_out(const Frame& frame);
  void assemble(const Frame& frame);
  [[nodiscard]] static bool uses_cached_plane(const Frame& frame, std::size_t c, bool late);
  void add_crossings(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch);
  void find_planes(const Frame& frame, Index begin, Index end, Scratch& scratch) const;
  void use_crease_normal(const Frame& frame, const Crossing& crossing, const SurfaceNormals::Weights& weights,
                         simd::WeightedPlane& plane) const;
  void add_border(const Frame& frame, std::size_t c, Scratch& scratch);
  BorderSums unusual_border(const Frame& frame, std::size_t c, Scratch& scratch);
  [[nodiscard]] simd::WeightedPlane unusual_plane(const Frame& frame, Index edge, Scratch& scratch) const;
  void add_links(const Frame& frame, std::size_t c);
  void use_cached_plane(const Frame& frame, std::size_t c);
  [[nodiscard]] static double reach(const Estimate& estimate);
  [[nodiscard]] NearFaces::Frame near_frame(const Frame& frame, const Scratch& scratch) const {
    return {frame.bodies, frame.positions, scratch.places, scratch.walks, inexact_};
  }
  void list_surfaces(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch);
  void add_beside(const NearFaces::Face& face, Scratch& scratch);
  void add_surfaces(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch);
  void set_propagation_source(std::size_t c);
  static Index own_point(const Frame& frame, std::size_t c);
  void propagate(const Frame& frame);
  void next_level(Index level);
  void balance(const Frame& frame);
  void solve_certainty(const Frame& frame);
  void leave_out(std::size_t c);
  void finish(const Frame& frame);
  void count(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) const;
  [[nodiscard]] DepthCounts sum_of_counts();
  [[nodiscard]] std::span<const Scratch> used_scratches() const {
    return std::span(scratches_).first(parallel::chunk_count(estimates_.size(), contacts_of_search));
  }
  [[nodiscard]] double relative_depth(const Frame& frame, std::size_t c) const;
  [[nodiscard]] bool is_deep(const Frame& frame, std::size_t c) const;
  bool finish_contact(const Frame& frame, std::size_t c, bool rough, ExitSearch& search);
  [[nodiscard]] double enough(const Frame& frame, std::size_t c) const;
  void raise_depths(const Frame& frame, Scratch& scratch);
  [[nodiscard]] double surface_bound(const Frame& frame, std::size_t c, double enough) const;
  void search_surface(const Frame& frame, std::size_t c, const NearFaces::Search& search,
                      ExitSearch& one_by_one);
  void raise_depth(const Frame& frame, std::size_t c, double distance, double enough);
  [[nodiscard]] bool find_deepest(const Frame& frame);
  void lead_out(const Frame& frame);
  void lead_contact_out(const Frame& frame, std::size_t c, double fraction, ExitSearch& search);
  void use_propagated_depth(const Frame& frame, std::size_t c);
  void set_unknown_depth(const Frame& frame, std::size_t c);
  Index regions_not_reached();

  SurfaceNormals normals_;
  double surely_enough_;  ///< an edge with a larger squared length is long enough
  double inexact_;        ///< by which distances may be wrong because of rounding
  PlaneSystem system_;
  std::vector<Index> border_begin_;  ///< (n_contacts + 1) first border edge of each contact
  std::vector<Estimate> estimates_;  ///< (n_contacts)
  std::vector<Index>
      levels_;  ///< (n_contacts) 0 at a crossing, otherwise the number of edges from one; or not_reached
  std::vector<Plane> planes_;    ///< (n_contacts) of the first guess
  std::vector<double> deepest_;  ///< (n_contacts) largest depth in its connected region, in edges
  std::vector<Index> frontier_;
  std::vector<Index> next_;
  std::vector<Scratch> scratches_;  ///< one for each chunk of contacts
};

}  // namespace palpate
