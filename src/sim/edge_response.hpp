#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "contact/detector_steps.hpp"
#include "contact/flush_faces.hpp"
#include "contact/rim_edges.hpp"
#include "contact/rim_falloff.hpp"
#include "fem/contact_law.hpp"
#include "fem/coupling.hpp"
#include "parallel/parallel.hpp"
#include "sim/pair_support.hpp"

namespace palpate {

class ContactResponse;

/// An end of the part of an edge that is inside a body, in a step.
struct EdgeEnd {
  Index edge = -1;
  Index body = -1;
  /// 2 x index of the part along the edge; + 1 for the far end of the part. `inset`: not an end, but a
  /// position beside a rim; its coupling is with its exit.
  Index end = 0;
  static constexpr Index inset = -1;
  std::array<Index, 5> points{};         ///< points of its coupling
  std::array<double, 5> coefficients{};  ///< coefficients of its coupling
  bool of_edge =
      true;  ///< true: the coupling is between two points and a triangle; false: between a point and a tet
  fem::ContactLaw law;
  Vec3 velocity{};               ///< relative velocity of the two positions, m/s
  double chatter_damping = 0.0;  ///< N s/m
  std::int32_t lost = 0;         ///< steps since it was inside
  bool acts = false;             ///< acted in the last step
  [[nodiscard]] auto key() const { return std::tuple(edge, body, end); }
  [[nodiscard]] fem::Coupling coupling() const;
};

/// Forces of edges where contacts of points do not suffice (docs/edges.md): of edge contacts, and of edges at
/// rims. Both act at the ends of the part that is inside: where the edge meets the surface of the body, by a
/// coupling of its two points with the corners of the triangle there, or at a point of it that is in contact
/// itself. Force and reaction act at one position.
///
/// The stiffness at an end is half that of a contact (each point has some edges) times weights that keep
/// forces continuous:
/// - It grows with the length of the part, up to the reach of a rim (RimFalloff), and with the angle of the
///   edge's own body: a flat edge, between the triangles of a face, has no force.
/// - If an end of the edge approaches from outside through a face along the direction, it will become a
/// contact
///   that needs no help. So the force of the part vanishes before that. An end near the plane of the face
///   counts as approaching: in flush and slightly uneven faces these are all ends.
/// - What points support need no edges. For an edge contact these are the corners of the triangle that it
/// meets
///   and their neighbours, by their depth and their scale at rims. Edges at rims act as far as the points of
///   the two bodies do not resist tilting (PairSupport), and the points of the edge do not support it.
/// - Edges that enter or leave through a face that lies flush on another rigid body have none (FlushFaces).
///
/// Where points support the bodies, those at the borders of flush faces have no force, and soft borders would
/// sink in. There, edges from a point that is supported to one at a rim act at an inset, a quarter of the
/// edge beside the rim (RimEdgeSearch::find_inset). Its stiffness is half that of a contact times what the
/// point at the rim lacks by its falloff, the falloff of the inset itself, and the part of their support that
/// points give (PairSupport). Insets act only where the contact of the supported point has sunk in
/// noticeably, and are never speculative. No weight falls as the depth of the inset grows.
class EdgeResponse {
 public:
  /// The force of an edge at one position.
  struct Row {
    EdgeEnd end;
    double depth = 0.0;  ///< at the start of the step, m; negative: a gap
    double force = 0.0;  ///< along the direction, on the edge, N
  };
  /// Input: positions and the contacts at them.
  struct Frame {
    const ContactResponse& rules;
    const DetectedSurfaces& surfaces;
    const RimFalloff& rims;
    const parallel::Threads& threads;
    const Bodies& bodies;
    const ContactTable& table;
    std::span<const Vec3> positions;
    std::span<const Vec3> velocities;
    double since = 0.0;      ///< length of the step before, s
    double time_step = 0.0;  ///< length of the step, s
    double fall = 0.0;       ///< distance by which gravity moves a body in a step, m
    /// (n_contacts) stiffness scale of each contact near rims, 0 to 1.
    std::span<const double> scales;
    const FlushFaces& flush;
  };

  /// Makes the rows at the start of a step; those of the last step are discarded. O(edge contacts + edges of
  /// contacts at rims, log), parallel.
  std::span<const Row> begin(const Frame& frame);
  /// Appends rows of the last step whose ends are outside now but may be inside within this step, with their
  /// gaps; like KeptContacts, and for the same reason. O(rows log).
  std::span<const Row> near(const Frame& frame);
  /// Rows at the end of a step that do not act yet but would push, with their gaps and `force`. Valid until
  /// the next call. They act only after take().
  [[nodiscard]] std::span<const Row> meet(const Frame& frame);
  /// Makes the rows of the last meet() act.
  void take();
  /// Call after a failed step: restores the rows of the step before.
  void undo() { now_.swap(before_); }

  /// The rows of the last step, sorted by key: part of the saved state.
  [[nodiscard]] const std::vector<EdgeEnd>& ends() const { return now_; }
  void set_ends(std::vector<EdgeEnd> ends) { now_ = std::move(ends); }

 private:
  [[nodiscard]] bool acts(const EdgeEnd& end) const;
  void list(const Frame& frame);
  void measure_support(const Frame& frame);
  void list_edge_contacts(const Frame& frame);
  void list_rim_edges(const Frame& frame);
  void list_insets(const Frame& frame);
  void sort_rows();
  void add_edge_contact(const Frame& frame, std::size_t contact, Index number, std::vector<Row>& rows) const;
  void add_rim_edges(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                     std::vector<Row>& rows) const;
  [[nodiscard]] double stiffness_of_an_end(const Frame& frame, Index own, Index body) const;
  void add_rim_edge(const Frame& frame, Index body, const RimEdge& found, std::vector<Row>& rows) const;
  void add_insets(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                  std::vector<Row>& rows) const;
  [[nodiscard]] static double width_of_inset(const Frame& frame, Index edge, Index body);
  void add_inset_of_border_edge(const Frame& frame, std::size_t number, RimEdgeSearch& search,
                                std::vector<Row>& rows) const;
  void add_inset(const Frame& frame, Index contact, Index edge, double weight, RimEdgeSearch& search,
                 std::vector<Row>& rows) const;
  /// Appends the rows that add(i, search, rows) makes for each i < size.
  template <class Add>
  void append_rows(const Frame& frame, std::size_t size, const Add& add);

  std::vector<Index> numbers_;  ///< (n_edge_contacts) index of the part of its edge in the body
  PairSupport support_;
  std::vector<Index> unsupported_;  ///< contacts in pairs of bodies that lack support: their edges may act
  std::vector<Index> at_rims_;      ///< contacts at rims, in pairs with some support: insets may act
  std::vector<RimEdgeSearch> searches_;  ///< one for each chunk of contacts at rims
  parallel::ChunkedList<Row> lists_;
  std::vector<Row> rows_;
  std::vector<EdgeEnd> now_;     ///< rows that act and rows that were lost
  std::vector<EdgeEnd> before_;  ///< rows of the step before
};

}  // namespace palpate
