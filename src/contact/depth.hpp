#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_list.hpp"
#include "contact/crossings.hpp"
#include "contact/deadline.hpp"
#include "contact/edge_exit.hpp"
#include "contact/nearest_surface.hpp"
#include "contact/plane_system.hpp"
#include "contact/remembered_planes.hpp"
#include "contact/surface_normals.hpp"
#include "geometry/vector.hpp"

namespace palpate {

/// Consistent penetration depth and direction, for each pair of a body and one that it penetrates; after
/// Heidelberger, Teschner, Keiser, Mueller & Gross, "Consistent penetration depth estimation for deformable
/// collision response", 2004, made continuous. docs/depth.md derives it and says where it still jumps.
///
/// Each crossing x with the outward normal n of the surface there is a plane, the way out as that border edge
/// sees it. A contact's plane is the mean of those of its border edges and of the planes of its neighbours in
/// contact, weighted by 1 / |x - p|^2 and 1 / |q - p|^2. Depth is the distance to the plane, direction its
/// normal. Deviations from the paper: it averages the neighbours breadth first, each contact once; here all
/// contacts are averages of all their neighbours at once (a linear system, with the paper's values as first
/// guess), for only then nothing jumps where a point enters or leaves the body. Normals turn continuously
/// along the surface. A depth is never less than the distance to the surface. Where a region has no border
/// edge, the nearest surface point is taken.
class DepthEstimate {
 public:
  explicit DepthEstimate(const Bodies& bodies);

  /// Fills depth and direction of all contacts; returns what it could not do the usual way (the fields of
  /// DetectionCounts that tell of depths). O(contacts x edges at a point x iterations + triangles + fallbacks
  /// x tets nearer than the surface), parallel, without a deadline the same bits for every thread count.
  /// After the deadline contacts go by what they remember, means are not balanced any more, nobody looks
  /// whether a depth is less than the distance to the surface, and where nothing is known a depth is zero.
  /// Contacts have border edges where `planes` finds their way out anew. Those that it
  /// remembers have depth and direction from there, and the others see them as a plane that is known.
  DepthCounts compute(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                      ContactList& contacts, const BorderEdges& border_edges, const CrossingQuery& crossings,
                      const RememberedPlanes& planes = {}, const Deadline& deadline = {});
  /// How a contact came to its plane.
  [[nodiscard]] RememberedPlanes::Outcome outcome(std::size_t contact) const {
    using Outcome = RememberedPlanes::Outcome;
    const Note& note = notes_[contact];
    if (note.remembered) return Outcome::remembered;
    if (!note.rough) return Outcome::found;
    return note.border_weight > 0.0 ? Outcome::guessed : Outcome::none;
  }

 private:
  /// One frame's input.
  struct Frame {
    const parallel::Threads& threads;
    const Bodies& bodies;
    std::span<const Vec3> positions;
    ContactList& list;
    std::span<const BorderEdge> border_edges;
    const BorderEdges& links;
    const CrossingQuery& crossings;
    const RememberedPlanes& planes;
    const Deadline& deadline;
  };
  /// What is known of a contact besides its plane.
  struct Note {
    Index level = -1;               ///< 0 at a crossing, else steps of propagation from one; -1: not reached
    Index without_crossing = 0;     ///< border edges
    double edges = 0.0;             ///< sum of 1 / length^2 of all edges of the point
    double border_edges = 0.0;      ///< of those with a crossing
    double border_weight = 0.0;     ///< of all its crossings
    double nearest_crossing = 0.0;  ///< distance
    double nearest_surface = 0.0;   ///< distance of what is beside it; infinite: nothing is
    double deepest = 0.0;           ///< of the neighbours that its first guess comes from
    double bound = 0.0;             ///< no depth grows by more than the way from a neighbour
    double knowledge = 1.0;         ///< what reaches it of the planes, 0 to 1
    bool fixed = false;             ///< its plane is that of its crossings alone, or an earlier one
    std::uint8_t from_surface = 0;  ///< a Source
    bool remembered = false;        ///< its plane is an earlier one
    bool rough = false;             ///< there was no time to refine it
  };
  /// A surface triangle beside a contact.
  struct Beside {
    std::size_t contact;
    double distance;
    double weight;
  };
  /// Memory of a chunk of contacts.
  struct Scratch {
    /// With room for what contacts of usual meshes need, so that steady steps ask for no more.
    Scratch() {
      crossed.reserve(1024);
      exits.reserve(1024);
      points.reserve(1024);
      beside.reserve(1024);
      normals.reserve(1024);
    }
    ExitSearch search;
    std::vector<CrossedEdge> crossed;   ///< border edges that have one crossing
    std::vector<EdgeExit> exits;        ///< (n_crossed)
    std::vector<TrianglePoint> points;  ///< what is beside contacts
    std::vector<Beside> beside;         ///< (n_points)
    std::vector<Vec3> normals;          ///< (n_points)
  };
  /// Why depth or direction of a contact is that of the nearest surface point.
  enum Source : std::uint8_t { from_planes, no_border, raised, cancelled };

  static constexpr std::size_t contacts_of_search = 64;  ///< a chunk
  /// Squared length of an edge as weights use it: never zero, where points of tissue fall onto each other.
  [[nodiscard]] double squared_distance(const Frame& frame, Index p, Index q) const {
    const double now = squared_length(at(frame.positions, q) - at(frame.positions, p));
    return now >= surely_enough_ ? now : longer_distance(frame, p, q, now);
  }
  [[nodiscard]] static double longer_distance(const Frame& frame, Index p, Index q, double now);
  void lay_out(const Frame& frame);
  void assemble(const Frame& frame);
  void assemble_contacts(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch);
  [[nodiscard]] static bool goes_by_memory(const Frame& frame, std::size_t c, bool late);
  void find_normals(const Frame& frame, Scratch& scratch) const;
  void list_crossings(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) const;
  void add_border(const Frame& frame, std::size_t c, const EdgeExit*& next_exit);
  void add_links(const Frame& frame, std::size_t c);
  void take(const WayOut& way, Contacts& contacts, std::size_t c);
  [[nodiscard]] static double reach(const Note& note);
  void list_surfaces(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) const;
  void list_surface(const Frame& frame, std::size_t c, double reach, Scratch& scratch) const;
  void add_surface(const Frame& frame, std::size_t c, const Scratch& scratch, std::size_t& next);
  void make_guess(const Frame& frame, std::size_t c);
  static Index own_point(const Frame& frame, std::size_t c);
  void propagate(const Frame& frame);
  void next_level(Index level);
  void balance(const Frame& frame);
  void weigh_knowledge(const Frame& frame);
  void leave_out(std::size_t c);
  void finish(const Frame& frame);
  void finish_contact(const Frame& frame, std::size_t c, bool rough, ExitSearch& search);
  void take_guess(const Frame& frame, std::size_t c);
  void know_nothing(const Frame& frame, std::size_t c);
  Index regions_not_reached();

  SurfaceNormals normals_;
  double surely_enough_;  ///< squared length of an edge that is not too short, whichever it is
  PlaneSystem system_;
  std::vector<std::uint8_t> penetrated_;  ///< (n_bodies) by contacts that find their way out
  std::vector<Index> border_begin_;       ///< (n_contacts + 1) border edges of each contact
  std::vector<Note> notes_;               ///< (n_contacts)
  std::vector<Plane> planes_;             ///< (n_contacts) of the first guess
  std::vector<Index> frontier_;
  std::vector<Index> next_;
  std::vector<Scratch> scratches_;  ///< of each chunk of contacts
};

}  // namespace palpate
