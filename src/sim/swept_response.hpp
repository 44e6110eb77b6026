#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/contact_table.hpp"
#include "contact/exits_back.hpp"
#include "contact/swept_query.hpp"
#include "fem/contact_law.hpp"
#include "fem/coupling.hpp"
#include "parallel/parallel.hpp"
#include "sim/pair_support.hpp"
#include "sim/response.hpp"

namespace palpate {

/// The prediction of a step by a solve.
struct PredictedStep {
  std::span<const Vec3> start;       ///< (n_points x 3), m
  std::span<const Vec3> end;         ///< (n_points x 3), m
  std::span<const Vec3> velocities;  ///< (n_points x 3), m/s; not (end - start) / time_step if a body rotates
  double time_step = 0.0;            ///< s
  const ContactTable& contacts;      ///< at `end`
  bool complete = true;              ///< no contact at `end` may be missing
};

/// Stops points and edges that would pass through another body within a step and end on the wrong side, and
/// contacts of the start of the step that would leave the body on the other side.
///
/// The paths begin where the bodies do not overlap: points and edges in shallow contact are displaced out of
/// the body for the search.
///
/// A pair from SweptQuery is relevant if it enters a body from outside (the direction is within the range of
/// normals there) and ends on the other side. The direction rotates with the primitives until the end of the
/// step. If a contact at the end of the step pushes it back to the side of entry, that contact suffices. All
/// others get a law that keeps them apart: without damping and without memory of friction, like the
/// speculative contacts of ContactResponse. Its stiffness stops the mass of their points within a fiftieth of
/// the local thickness; it is multiplied by ten each time that they still pass in about this direction. What
/// is nearer than that at the start of the step may come half of the gap nearer, so that contacts take over.
class SweptResponse {
 public:
  explicit SweptResponse(const Bodies& bodies);

  /// Begins a step, in which nothing has been stopped yet. O(contacts + edge contacts).
  /// \param positions  at the start of the step (n_points x 3)
  /// \param contacts   at these positions
  void begin_step(std::span<const Vec3> positions, const ContactTable& contacts);
  /// How thick the bodies are.
  [[nodiscard]] const LocalThickness& thickness() const { return query_.thickness(); }
  /// Call after ContactResponse::compute() of the step: lists pairs of bodies whose contacts act softly.
  /// O(contacts).
  void list_soft_pairs(const ContactTable& contacts);

  /// Laws and couplings for the pairs that pass; empty if nothing ends on a wrong side. Valid until the next
  /// call. Time: SweptQuery::find(), and O(found log found + contacts + edge contacts log(edge contacts)).
  /// \param contacts  of the start of the step; their laws are the first ones of the response
  std::span<const StopOfPassing> find(const parallel::Threads& threads, const PredictedStep& step,
                                      const PairFilter& filter, const ContactResponse& response,
                                      std::span<const fem::Coupling> contacts);
  /// Makes the pairs of the last find() act, and those that were stopped before in this step agree with the
  /// same predicted step. O(stops of the step).
  void stop(const PredictedStep& step, ContactResponse& response, std::vector<fem::Coupling>& couplings);
  /// Whether the last find() has a pair of two bodies of which nothing was stopped before in this step.
  [[nodiscard]] bool stops_new_pair() const;
  /// Number of pairs of the last find() that still pass after most_stops.
  [[nodiscard]] std::int64_t left() const { return left_; }
  /// Counts what could pass, without a search; see counts().
  /// \param least_motion  see SweptSettings
  void count(const parallel::Threads& threads, const PredictedStep& step, const PairFilter& filter,
             double least_motion = SweptSettings{}.least_motion);
  /// Counts of the last find() or count().
  [[nodiscard]] const SweptCounts& counts() const { return query_.counts(); }

 private:
  /// Margin relative to the local thickness: a pair is stopped this far before the touch, and counts as
  /// passed this far beyond it.
  static constexpr double margin_of_thickness = 0.02;

  /// A pair that was stopped in this step; one entry for each stop.
  struct Key {
    SweptKind kind;
    Index first;
    Index second;  ///< body of a point, or the other edge; negative: an end of an edge contact
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  struct Stopped {
    Key key;
    Vec3 direction;
  };
  /// A contact of the start of the step, or one end of an edge contact.
  struct Start {
    Key key;
    const fem::Coupling& coupling;
    const Vec3& direction;
    double depth;  ///< m
    bool of_edge;
    double thickness;  ///< of the body there, m
  };
  /// A pair to keep apart, with direction and distances.
  struct Passing {
    const fem::Coupling& coupling;
    const Vec3& direction;
    double nearest;  ///< distance at the end of the step at which the law has no force, m
    double beyond;   ///< predicted motion beyond the allowed approach, m
    double margin;   ///< distance within which it must be stopped, m
    bool of_edge;    ///< the first two points of the coupling are an edge
  };
  /// Displacements of points that separate the bodies where they overlap little.
  struct Separation {
    struct Shift {
      Index point;
      Vec3 by;
    };
    std::vector<Shift> shifts;
    std::vector<Vec3> places;  ///< positions with shifts; empty until separated() is called

    void clear();
    std::span<const Vec3> separated(std::span<const Vec3> positions);
  };
  [[nodiscard]] PairOfBodies bodies_of(const StopOfPassing& stop) const;
  [[nodiscard]] Key key_of(const SweptContact& contact) const;
  [[nodiscard]] fem::Coupling coupling_of(const SweptContact& contact) const;
  [[nodiscard]] double thickness(const SweptContact& contact) const;
  void add(const SweptContact& contact, const PredictedStep& step, std::span<const Vec3> start,
           const ContactResponse& response);
  void add_sinking(const PredictedStep& step, const ContactResponse& response,
                   std::span<const fem::Coupling> contacts);
  void add_sinking(const Start& start, const PredictedStep& step, const ContactResponse& response);
  [[nodiscard]] bool in_thin(const Start& start, Index body) const;
  [[nodiscard]] static bool point_reverses(const Start& start, Index row, const PredictedStep& step);
  [[nodiscard]] static bool edge_reverses(const Start& start, Index body, const PredictedStep& step);
  [[nodiscard]] static bool slides_on(const Start& start, Index body, const PredictedStep& step);
  [[nodiscard]] bool leaves(const Start& start, Index body, bool deeper, const PredictedStep& step) const;
  [[nodiscard]] std::ptrdiff_t times_stopped(const Key& key, const Vec3& direction) const;
  void add(const Key& key, const Passing& passing, const PredictedStep& step,
           const ContactResponse& response);
  void list_ends(std::span<const Vec3> positions, const EdgeContacts& contacts);
  /// Which contacts have a shift.
  struct Shallow {
    double deepest;   ///< of a contact, relative to the local thickness of the penetrated body
    bool of_thinner;  ///< and to that of the point or edge, so that no shift is larger than its body
  };
  void list_shifts(const ContactTable& contacts, const Shallow& shallow, Separation& list) const;
  [[nodiscard]] bool is_soft(Index point, Index body) const;
  [[nodiscard]] double overlap_before(const SweptContact& contact, const fem::Coupling& coupling,
                                      std::span<const Vec3> start) const;
  [[nodiscard]] static double gap_of(const StopOfPassing& stop, double nearest, const PredictedStep& step);
  [[nodiscard]] SweptSettings settings() const { return {.tolerance = tolerance_}; }

  const Bodies& bodies_;
  SweptQuery query_;
  ExitsBack exits_;
  double tolerance_;
  /// An end of an edge contact of the start of the step.
  struct StartEnd {
    Key key;
    fem::Coupling coupling;
    Vec3 direction;
    double depth = 0.0;      ///< m
    double thickness = 0.0;  ///< of the body there, m
  };
  std::vector<StartEnd> start_ends_;
  std::vector<PairOfBodies> soft_pairs_;     ///< whose contacts began deep and act softly, sorted
  Separation start_;                         ///< at the start of the step
  Separation end_;                           ///< at its predicted end
  std::vector<Stopped> stopped_;             ///< ascending by key
  std::vector<Stopped> now_;                 ///< scratch
  std::vector<PairOfBodies> stopped_pairs_;  ///< in this step, ascending
  std::vector<StopOfPassing> stops_;
  std::vector<double>
      nearest_;  ///< (n_stops) distance at the end of the step at which each law has no force, m
  /// A law of a stop in this step.
  struct Acting {
    std::size_t law;  ///< its index in the response
    StopOfPassing stop;
    double nearest;  ///< as in nearest_
  };
  std::vector<Acting> acting_;
  std::int64_t left_ = 0;
};

}  // namespace palpate
