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
#include "contact/nearest_surface.hpp"
#include "contact/rim_edges.hpp"
#include "contact/surface_normals.hpp"
#include "fem/contact_law.hpp"
#include "fem/coupling.hpp"
#include "parallel/parallel.hpp"
#include "sim/pair_support.hpp"

namespace palpate {

class ContactResponse;

/// An end of the part of an edge that is in a body, as a step had it.
struct EdgeEnd {
  Index edge = -1;
  Index body = -1;
  Index end = 0;  ///< 2 x number of the part that is inside, along the edge, + 1 for the end of the part
  std::array<Index, 5> points{};         ///< of its coupling
  std::array<double, 5> coefficients{};  ///< the same
  bool of_edge = true;  ///< the coupling is of two points with a triangle; else of a point with a tet
  fem::ContactLaw law;  ///< its depth is that where the two places of the coupling are one
  Vec3 velocity{};      ///< of the two places to each other, m/s
  double chatter_damping = 0.0;  ///< N s/m
  std::int32_t lost = 0;         ///< steps since it was inside
  bool acts = false;             ///< in the last step
  [[nodiscard]] auto key() const { return std::tuple(edge, body, end); }
  [[nodiscard]] fem::Coupling coupling() const;
};

/// Forces of edges on bodies that their points alone do not hold (docs/edges.md): of edge contacts, and of
/// edges at rims. Both act at the ends of the part that is inside: where the edge meets the surface of the
/// body, by a coupling of its two points with the corners of the triangle there, or at a point of it that is
/// in contact itself. Force and reaction act at one place.
///
/// The stiffness at an end is half that of a contact (each point has some edges) times weights that let
/// nothing jump:
/// - it grows with the length of the part, up to the reach of a rim (RimFalloff), and with how sharply the
///   edge's own body folds there: a flat edge, between the triangles of a face, does nothing;
/// - where an end of the edge comes near from outside through a face that looks along the direction, it will
///   be a contact of its own that needs no help: so the part lets go before that. Near is what is not far
///   from the plane of the face: of faces that lie flush and are a little uneven all ends are;
/// - what points hold need not be held again. Near an edge contact these are the corners of the triangle that
///   it meets and their neighbours, by their depth and their scale at rims; edges at rims act as far as the
///   points of the two bodies do not hold them against tilting (PairSupport), and where those of the edge do
///   not.
class EdgeResponse {
 public:
  /// What acts at one place.
  struct Row {
    EdgeEnd end;
    double depth = 0.0;  ///< at the start of the step, m; negative: a gap
    double force = 0.0;  ///< along the direction, if nothing stops it, N
  };
  /// Positions and contacts there.
  struct Frame {
    const ContactResponse& rules;
    const SurfaceNormals& normals;
    const parallel::Threads& threads;
    const Bodies& bodies;
    const ContactTable& table;
    std::span<const Vec3> positions;
    std::span<const Vec3> velocities;
    double time_step = 0.0;
    double fall = 0.0;  ///< what gravity moves in a step, m
    /// (n_contacts) part of the stiffness that each has at a rim, 0 to 1.
    std::span<const double> scales;
  };

  /// Rows at the start of a step; those of the step before are dropped. O(edge contacts + edges of contacts
  /// at rims, log), parallel.
  std::span<const Row> begin(const Frame& frame);
  /// Behind them those of the last step that are not inside any more, but so near that they may be within
  /// this one, with their gaps: as contacts that are kept (KeptContacts), and for the same reason. O(rows
  /// log).
  std::span<const Row> near(const Frame& frame);
  /// At the end of a step those that do not act yet but push, with their gaps; `force` says how hard. Until
  /// the next call; nothing acts before take().
  [[nodiscard]] std::span<const Row> meet(const Frame& frame);
  /// Those of the last meet() act now.
  void take();
  /// The step failed: those of the step before are the last ones again.
  void undo() { now_.swap(before_); }

  /// Of the last step: part of the state that a resumed run needs. Sorted by key.
  [[nodiscard]] const std::vector<EdgeEnd>& ends() const { return now_; }
  void set_ends(std::vector<EdgeEnd> ends) { now_ = std::move(ends); }

 private:
  [[nodiscard]] bool acts(const EdgeEnd& end) const;
  void list(const Frame& frame);
  void add_edge_contact(const Frame& frame, std::size_t contact, Index number, std::vector<Row>& rows) const;
  void add_rim_edges(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                     std::vector<Row>& rows) const;
  void add_rim_edge(const Frame& frame, Index body, const RimEdge& found, std::vector<Row>& rows) const;

  std::vector<Index> numbers_;  ///< (n_edge_contacts) of the parts of an edge in a body
  PairSupport support_;
  std::vector<Index> at_rims_;           ///< contacts of pairs that lack support
  std::vector<RimEdgeSearch> searches_;  ///< of the chunks of contacts at rims
  parallel::ChunkedList<Row> lists_;
  std::vector<Row> rows_;
  std::vector<EdgeEnd> now_;     ///< those that act, and those that have ended
  std::vector<EdgeEnd> before_;  ///< of the step before
};

}  // namespace palpate
