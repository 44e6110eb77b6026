#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/settings.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// Contacts: points that lie in a tet of another body (closed tets; of several tets of one body, the lowest
/// index). With self-collision also points in a tet of their own body, unless they are a corner of it or lie
/// in it because tissue is inverted there (docs/depth.md). Structure of arrays, sorted by (point, body); a
/// point in two other bodies is two contacts.
struct Contacts {
  std::vector<Index> point;  ///< (n) the point that is inside
  std::vector<Index> body;   ///< (n) the penetrated body
  std::vector<Index> tet;    ///< (n) the penetrated tet
  std::vector<std::array<double, 4>>
      weights;                  ///< (n x 4) barycentric weights of the point in the tet, corner order
  std::vector<double> depth;    ///< (n) penetration depth, >= 0
  std::vector<Vec3> direction;  ///< (n x 3) unit vector out of the penetrated body
  /// (n) confidence weight of the direction: 1 where the surface around is flat, 0 where directions cancel,
  /// no plane reaches the point, or the nearest surface point was used. A change of the surroundings rotates
  /// the direction by at most that change divided by the certainty.
  std::vector<double> certainty;
  [[nodiscard]] std::size_t size() const { return point.size(); }  ///< number of contacts n
};

/// Surface edges that pass through another body (with self-collision, also through their own) with both ends
/// outside (docs/edges.md). Where the surfaces of two bodies meet, or one body is in the other, there is a
/// contact or an edge contact. Structure of arrays, sorted by (edge, body, parameter); an edge that goes
/// through a body twice is two.
struct EdgeContacts {
  std::vector<Index> edge;                      ///< (n) of Bodies::edges()
  std::vector<Index> body;                      ///< (n) the body that it passes through
  std::vector<std::array<Index, 2>> triangles;  ///< (n x 2) where it enters and where it leaves
  /// (n x 2) parameters of these places on the edge, 0 at its first point and 1 at its second; equal where it
  /// only touches.
  std::vector<std::array<double, 2>> parameters;
  std::vector<double> depth;    ///< (n) distance by which the edge must move to leave the body, >= 0
  std::vector<Vec3> direction;  ///< (n x 3) unit vector; along it
  [[nodiscard]] std::size_t size() const { return edge.size(); }  ///< number of edge contacts n
};

/// An edge with one end in contact with a body and the other end not in contact with it, or in contact with
/// another layer of it (self-collision only).
struct BorderEdge {
  Index contact;     ///< index into Contacts: the end that is in contact, and the penetrated body
  Index free_point;  ///< the other end
};

/// The crossing of a border edge and a surface triangle of the penetrated body; with self-collision, of a
/// triangle without a corner on the edge.
struct Crossing {
  Index border_edge;  ///< index into Detector::border_edges()
  Index triangle;     ///< of Bodies::triangles()
  double parameter;   ///< 0 at the point in contact, 1 at the free end
};

/// An edge length of cells that the automatic choice tried, and the work of a query of all tets (in clusters,
/// for the compact grid) with it.
struct CellSizeTrial {
  double cell_size = 0.0;  ///< m
  double lookups = 0.0;    ///< rows of cells looked up
  double visits = 0.0;     ///< points visited in them
  double work = 0.0;       ///< weighted sum, with that of the grid update: the smallest is chosen
};

/// The chosen edge length of cells, and the reason.
struct CellSizeChoice {
  CellSize wanted;                    ///< as set
  double cell_size = 0.0;             ///< as chosen, m
  std::vector<CellSizeTrial> trials;  ///< empty unless the choice was automatic
};

/// Load of a cuckoo hash table, and counts of its construction (docs/structures.md). With the default sizes,
/// buckets have 409 cells on average in 576 slots: a load of 71 % for many cells.
struct CuckooCounts {
  std::size_t cells = 0;            ///< number of keys: cells that are not empty
  std::size_t slots = 0;            ///< of all buckets
  std::size_t buckets = 0;          ///< number of buckets
  std::size_t bucket_retries = 0;   ///< new hash functions of a bucket, because evictions did not end
  std::size_t redistributions = 0;  ///< new hash functions into buckets, because one overflowed
  std::size_t growths = 0;          ///< larger tables, because new functions did not help
  /// Number of all new choices of hash functions.
  [[nodiscard]] std::size_t retries() const { return bucket_retries + redistributions; }
  /// Fraction of the slots that hold a key, 0 to 1.
  [[nodiscard]] double occupancy() const {
    return slots == 0 ? 0.0 : static_cast<double>(cells) / static_cast<double>(slots);
  }
};

/// Counts of depths that were not computed from crossings, by kind (docs/depth.md).
struct DepthCounts {
  /// Contacts whose direction is that to the nearest surface point. Their depth is the distance to it, except
  /// for cancelled_directions.
  std::size_t depth_fallbacks = 0;
  std::size_t cancelled_directions = 0;  ///< of these, because the planes' normals add up to nothing
  /// Contacts whose planes gave less than the distance to the surface; that distance is their depth.
  std::size_t raised_depths = 0;
  std::size_t regions_without_border = 0;  ///< connected contacts of which no border edge has a crossing
  std::size_t border_edges_without_crossing = 0;  ///< only with folded or overlapping tets
  /// With a budget in milliseconds: contacts whose depth there was no time to compute. Their depth is the
  /// distance to their cached plane, which moves with the tissue; contacts without one have a propagated
  /// depth.
  std::size_t rough_depths = 0;
};

/// Counts of one detection. Counts are the same on every machine, times are not.
struct DetectionCounts : DepthCounts {
  std::size_t contacts = 0;       ///< points in tets of other bodies, or of their own
  std::size_t edge_contacts = 0;  ///< surface edges that pass through a body, both ends outside
  /// Without edge contacts: pairs of bodies whose surfaces cross although there is no contact between them,
  /// so that they pass through each other. They are sought in every eighth detection, and the number stays
  /// until the next search. Zero with edge contacts.
  std::size_t unseen_pairs = 0;
  std::size_t border_edges = 0;  ///< with one end in contact and the other not
  std::size_t crossings = 0;     ///< of border edges with the surface
  std::size_t candidates = 0;    ///< pairs proposed and tested, both queries; of clusters: docs/query.md
  std::size_t folded_pairs = 0;  ///< points in tets of their own body because tissue is inverted there
  std::size_t movers = 0;  ///< points whose cell changed since the last detection; all, after a new domain
  /// Approximate mode: primitives (tets and border edges) that cover more cells than they have slots.
  std::size_t approximated_primitives = 0;
  std::size_t dropped_cells = 0;  ///< approximate mode: cells that were left out
  /// With a budget: clusters of tets, and of triangles of penetrated bodies, that were not queried.
  std::size_t late_clusters = 0;
  double completeness = 1.0;  ///< fraction of those clusters that were queried, 0 to 1; 1 without a budget
  std::optional<Sort>
      sort;                ///< the sort that was used last, never adaptive; none: the structure does not sort
  std::size_t cells = 0;   ///< cells of the domain
  double cell_size = 0.0;  ///< as used: the wanted one times 2^cell_doublings
  int cell_doublings = 0;  ///< of the wanted cell size, for a domain of more than 2^21 cells an axis
  /// The cuckoo table of points; none with other structures.
  std::optional<CuckooCounts> cuckoo_points;
  std::optional<CuckooCounts> cuckoo_edges;  ///< the table of border edges
};

/// The cells of a detection (paper 4.1, eq. 2): cell (i, j, k) begins at lower + cell_size (i, j, k).
struct CellDomain {
  Vec3 lower{};                         ///< lower corner of the domain, m
  std::array<Index, 3> cells{0, 0, 0};  ///< along x, y, z
  double cell_size = 0.0;               ///< edge length of a cell, m
};

/// Seconds of the phases of one detection.
struct DetectionTimes {
  double grid = 0.0;          ///< s, putting the points into cells
  double contacts = 0.0;      ///< s, points in tets
  double border_edges = 0.0;  ///< s
  double crossings = 0.0;     ///< s, border edges with the surface, and edge contacts
  double depth = 0.0;         ///< s, depths and directions
  DetectionTimes& operator+=(const DetectionTimes& other);  ///< adds each phase
};

/// The state of a detector that depends on earlier frames, to be saved; only a detector interprets its
/// fields. It affects counts (movers, sort), and the contacts found only in approximate mode and with a
/// budget.
struct DetectorMemory {
  double cell_size = 0.0;             ///< as chosen at the first detection; 0 before it
  std::vector<CellSizeTrial> trials;  ///< of that choice
  Vec3 lower{};                       ///< lower corner of the domain, m
  Vec3 upper{};                       ///< upper corner of the domain, m
  std::uint64_t detections = 0;       ///< number of detections so far
  bool repairs = true;                ///< state of the switch of Sort::adaptive: true for repair
  DetectionCounts counts;             ///< of the last detection
  /// With a budget: state of each cluster of tets in the queue, before the last detection.
  std::vector<std::uint8_t> tet_states;
  std::vector<std::uint8_t> triangle_states;  ///< the same of the clusters of triangles
  double fraction = 1.0;                      ///< fraction of the budget in the last detection
  /// With coherence: reference positions of the near lists, (n_points x 3) in fractions of a cell, or empty.
  std::vector<std::array<std::int32_t, 3>> reference_points{};
  std::array<std::int64_t, 8> coherence{};  ///< counters that decide when near lists are made
  bool skipped_grid = false;                ///< the last detection needed no grid
};

/// Finds the contacts among bodies and their depths, frame by frame.
///
/// The result equals that of exact arithmetic on the given positions. It has the same bits for every
/// structure, order, sort and thread count. Keeps its buffers from frame to frame.
class Detector {
 public:
  /// Throws Error if a setting is out of range.
  /// \param bodies     must outlive the detector
  /// \param immovable  per body; pairs of two immovable bodies are not tested. Empty: no body is.
  /// \param threads    number of threads; 0 takes all
  Detector(const Bodies& bodies, const DetectionSettings& settings, std::vector<std::uint8_t> immovable = {},
           int threads = 0);
  ~Detector();
  /// A moved-from detector can only be assigned to or destroyed.
  Detector(Detector&&) noexcept;
  /// Frees the data of this detector; the other can then only be assigned to or destroyed.
  Detector& operator=(Detector&&) noexcept;

  /// Finds all contacts at `positions` (n_points x 3). Expected time O(points + tets + contacts); with
  /// Structure::brute O(points x tets). Throws Error if a position is not finite.
  /// \param budget_fraction  of the budget that it may spend, > 0
  void detect(std::span<const Vec3> positions, double budget_fraction = 1.0);

  /// Results of the last detect(); valid until the next.
  [[nodiscard]] const Contacts& contacts() const;
  /// Moves the contacts to the caller without a copy; contacts() is empty until the next detect().
  [[nodiscard]] Contacts take_contacts();
  /// The edge contacts; empty without DetectionSettings::edge_contacts.
  [[nodiscard]] const EdgeContacts& edge_contacts() const;
  /// Sorted by (contact, edge). With a budget in milliseconds, only those of contacts whose depth was
  /// computed (docs/budget.md).
  [[nodiscard]] std::span<const BorderEdge> border_edges() const;
  [[nodiscard]] std::span<const Crossing> crossings() const;  ///< sorted by (border edge, triangle)
  /// Counts of the last detect(); the same on every machine.
  [[nodiscard]] const DetectionCounts& counts() const;
  /// Seconds of the phases of the last detect().
  [[nodiscard]] const DetectionTimes& times() const;
  /// The cells of the last detect().
  [[nodiscard]] CellDomain cell_domain() const;
  /// (n_bodies) 1 for bodies with tets or triangles that the budget left out: contacts in them may be
  /// missing, and depths in them may be less exact. Empty without a budget.
  [[nodiscard]] std::span<const std::uint8_t> late_bodies() const;
  /// Time in seconds that recent detections would have needed to find all contacts, with most depths from
  /// cached planes (DepthCounts::rough_depths); 0 without a budget.
  [[nodiscard]] double least_seconds() const;
  /// How the cell size was chosen, at the first detect().
  [[nodiscard]] const CellSizeChoice& cell_size_choice() const;
  /// Memory of the two structures (points, and border edges), bytes.
  [[nodiscard]] std::size_t structure_bytes() const;

  /// The state with which a new detector of the same bodies and settings continues like this one: recall().
  [[nodiscard]] DetectorMemory memory() const;
  /// Continues from the memory of another detector, with the positions of its last detect(): finds their
  /// contacts again. Throws Error on an invalid memory. Costs as much as detect().
  void recall(const DetectorMemory& memory, std::span<const Vec3> positions);

 private:
  friend class DetectorSteps;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
