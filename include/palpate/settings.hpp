#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include <palpate/types.hpp>

namespace palpate {

/// The spatial structure that finds candidates. The contacts found do not depend on it.
enum class Structure {
  uniform,  ///< an array of cells, each with a dynamic array (paper 4.1)
  compact,  ///< compact grid built by index sort (paper 4.2)
  hash,     ///< spatial hashing with chains (Teschner et al. 2003; paper 4.3)
  cuckoo,   ///< parallel two-level cuckoo hashing (Alcantara et al. 2009; paper 4.3)
  brute,    ///< all pairs: the oracle of all others, O(points x tets)
};
/// How the integer coordinates of a cell become one number.
enum class Order {
  linear,  ///< i + j s_x + k s_x s_y (paper eq. 1)
  z,       ///< bits of i, j and k interleaved: the Z-order curve (paper 5)
};
/// How the entries of the compact grid are sorted by cell index. The result does not depend on it.
enum class Sort {
  radix,       ///< least significant digit first, only the digits that the keys need
  counting,    ///< counting sort over the domain, which also gives C; for sparse domains, radix
  comparison,  ///< parallel comparison sort, faster for nearly sorted input (the paper's STL sort)
  repair,      ///< repairs the last frame's order by moving the movers
  adaptive,    ///< repair while few points move, otherwise counting or radix (the paper's switch, 5)
};
/// How the edge length of a cell is chosen (paper 5, "Cell size").
enum class CellSizeRule {
  automatic,  ///< the length with the least work for one query of the start configuration
  mean_edge,  ///< mean edge length at rest of all bodies
  max_edge,   ///< maximal edge length at rest of all bodies
};
/// A rule, or the length itself (> 0).
using CellSize = std::variant<CellSizeRule, double>;

/// Preconditioner of the conjugate gradients of a step. Affects convergence only: results agree within the
/// tolerance.
enum class Preconditioner {
  automatic,  ///< block Jacobi while solves take few iterations, otherwise multigrid; by counts, never by
              ///< time
  jacobi,     ///< the blocks of single points: cheap, good for soft tissue and few contacts
  multigrid,  ///< smoothed aggregation: for stiff or slender bodies, contacts, bad elements, large meshes
};
/// The quantity that the tolerance of a solve is relative to.
enum class ToleranceOf {
  /// The residual, relative to the right side or, where that is smaller (at rest), to the impulse of gravity
  /// and loads in a step.
  residual,
  /// The estimated error of the changes of velocity, relative to these or, where they are smaller, to those
  /// that gravity and loads alone would make.
  solution,
};

/// How a step computes velocities and positions at its end (docs/time-integration.md).
enum class TimeIntegration {
  implicit_euler,  ///< first order; damps what vibrates within few steps
  /// Second order, with less damping of motion, in steps in which contacts do not change. All other steps,
  /// and those after a change from outside, are implicit Euler.
  bdf2,
};

/// What a simulation does about parts that would pass through another body within a step
/// (docs/continuous.md).
enum class ContinuousDetection {
  off,  ///< counts pairs of bodies that could pass
  /// Stops them at the first touch, but searches many times in a step only where solves take little time:
  /// passes that are left are counted.
  limited,
  /// Searches on, if need be in substeps; counts what cannot be stopped. A step can take minutes.
  full,
};

/// The names that scenes and command lines use; index = enum value.
inline constexpr std::array<std::string_view, 3> continuous_detection_names{"off", "limited", "full"};
inline constexpr std::array<std::string_view, 3> preconditioner_names{"auto", "jacobi", "multigrid"};
inline constexpr std::array<std::string_view, 2> tolerance_of_names{"residual", "solution"};
inline constexpr std::array<std::string_view, 2> time_integration_names{"implicit-euler", "bdf2"};
inline constexpr std::array<std::string_view, 5> structure_names{"uniform", "compact", "hash", "cuckoo",
                                                                 "brute"};
inline constexpr std::array<std::string_view, 2> order_names{"linear", "z"};
inline constexpr std::array<std::string_view, 5> sort_names{"radix", "counting", "comparison", "repair",
                                                            "adaptive"};
inline constexpr std::array<std::string_view, 3> cell_size_rule_names{"auto", "mean-edge", "max-edge"};

/// A ball in space.
struct InterestRegion {
  Vec3 center{};        ///< m
  double radius = 0.0;  ///< m, > 0
  /// Whether a point (m) is in the ball or on its surface.
  [[nodiscard]] bool contains(const Vec3& point) const {
    const Vec3 away{point.x - center.x, point.y - center.y, point.z - center.z};
    return away.x * away.x + away.y * away.y + away.z * away.z <= radius * radius;
  }
  friend bool operator==(const InterestRegion&, const InterestRegion&) = default;
};
/// Limit of the cost of a detection. If it does not suffice, contacts are missed, and the counts say so
/// (docs/budget.md). Only for Structure::compact without cells_per_primitive.
struct Budget {
  /// Number of tested pairs in a detection (up to a few hundred more), the same ones in every run.
  std::optional<int> tests{};
  /// Milliseconds for all detections of a time step. Which contacts are found depends on the machine.
  std::optional<double> milliseconds{};
  std::optional<InterestRegion> region{};  ///< tested before other regions of the same importance
  friend bool operator==(const Budget&, const Budget&) = default;
};

/// Settings of contact detection.
struct DetectionSettings {
  Structure structure = Structure::compact;      ///< spatial data structure of the broad phase
  Order order = Order::linear;                   ///< numbering of cells
  Sort sort = Sort::adaptive;                    ///< of the entries; Structure::compact only
  CellSize cell_size = CellSizeRule::automatic;  ///< m, or the rule that chooses it
  /// Largest number of cells stored for a primitive, 1 to 27 (approximate mode, paper 5); none: exact.
  std::optional<int> cells_per_primitive;
  /// Per body: 1 for self-collision of a movable body. Empty: none.
  std::vector<std::uint8_t> self_collision;
  /// Pairs of two different bodies, in any order, that are not tested against each other. It may list all
  /// n_bodies^2 / 2 pairs, but each pair of a point and a tet that meet is searched in it.
  std::vector<std::array<Index, 2>> ignored_pairs{};
  /// Whether surface edges that pass through a body with both ends outside are found (docs/edges.md). If
  /// false, contacts are found as in the paper, and bodies that meet only edge on edge pass through each
  /// other.
  bool edge_contacts = true;
  /// Whether data of earlier frames are used to make frames with little motion faster. Contacts do not depend
  /// on it. For points, only with Structure::compact without cells_per_primitive and budget.
  bool coherence = true;
  /// Only for simulations: what is done about parts that would pass through another body within a step.
  ContinuousDetection continuous = ContinuousDetection::limited;
  std::optional<Budget> budget{};  ///< none: finds all contacts, without a limit
  friend bool operator==(const DetectionSettings&, const DetectionSettings&) = default;
};

/// Settings of contact forces: a penalty force along the direction, friction orthogonal to it
/// (docs/architecture.md, "Forces").
struct ResponseSettings {
  /// Force per depth at each point in contact, N/m; none: from material and element size of the two bodies.
  std::optional<double> stiffness;
  /// Damping along the direction, as a fraction of the critical damping of the point on its penalty spring;
  /// >= 0.
  double damping = 0.3;
  double friction = 0.0;  ///< Coulomb coefficient, >= 0
};

/// Settings of the solver of a step.
struct SolverSettings {
  double tolerance = 1e-4;                                    ///< at which the conjugate gradients stop, > 0
  ToleranceOf tolerance_of = ToleranceOf::solution;           ///< what `tolerance` is relative to
  Preconditioner preconditioner = Preconditioner::automatic;  ///< affects convergence only
  int max_iterations = 300;  ///< maximum; the metrics count solves that reach it
  /// Number of iterations of each solve regardless of the tolerance, for steps of equal time, > 0; none:
  /// until the tolerance is reached.
  std::optional<int> fixed_iterations{};
  /// Largest number of solves of a substep. Bodies that meet, or rotate fast, need more than one.
  int max_solves = 40;
  /// A step that does not converge, or in which a body rotates by more than 2 rad, is undone and divided into
  /// two substeps, and so are these. No substep is shorter than time_step / max_substeps; 1: steps are never
  /// divided. Substeps that may not be divided have four times max_iterations, and bodies may rotate further.
  /// 1 to most_substeps. Not used with fixed_iterations or a time budget.
  int max_substeps = 4;
  static constexpr int most_substeps = 64;  ///< upper bound of max_substeps
};

/// When bodies count as at rest: the root mean square speed (by mass) of each has been at most `speed` for
/// `time` without interruption, so that the first steps of a fall do not count as rest. A single trembling
/// point does not prevent rest; a moving body does.
struct RestSettings {
  double speed = 1e-3;  ///< m/s
  double time = 0.05;   ///< s
};

/// Limits above which a run counts as blown up and stops with an Error. A value that is not finite always
/// stops it.
struct LimitSettings {
  /// m/s, > 0; no point may be faster. None: 100 diagonals of the box of all points at the start per time
  /// step, plus the speed of a free fall.
  std::optional<double> max_speed{};
  /// s, > 0; a tet that has been inverted (volume <= 0) for this time without interruption stops the run.
  /// None: no limit, since elastic forces restore inverted tets (docs/inversion.md).
  std::optional<double> inverted_time{};
};

/// All settings of a simulation.
struct SimulationSettings {
  double time_step = 0.01;        ///< s, > 0
  Vec3 gravity{0.0, 0.0, -9.81};  ///< m/s^2
  DetectionSettings detection;    ///< contact detection
  ResponseSettings response;      ///< contact forces
  SolverSettings solver;          ///< solver
  RestSettings rest;              ///< when bodies count as at rest
  LimitSettings limits;           ///< when a run has blown up
  /// Method of time integration.
  TimeIntegration time_integration = TimeIntegration::implicit_euler;
};

}  // namespace palpate
