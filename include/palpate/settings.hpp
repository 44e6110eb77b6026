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
  counting,    ///< by counting over the domain, which gives C as well; where the domain is sparse, radix
  comparison,  ///< parallel sort by comparisons, which gains from sorted input (the paper's STL sort)
  repair,      ///< last frame's order with the movers put right
  adaptive,    ///< repair while few points move, else counting or radix (the paper's switch, 5)
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
  automatic,  ///< block Jacobi while solves take few iterations, else multigrid; by counts, never by time
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

/// The names that scenes and command lines use; index = enum value.
inline constexpr std::array<std::string_view, 3> preconditioner_names{"auto", "jacobi", "multigrid"};
inline constexpr std::array<std::string_view, 2> tolerance_of_names{"residual", "solution"};
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
/// What a detection may cost; where it does not suffice, contacts are missed, and the counts say so
/// (docs/budget.md). Only for Structure::compact without cells_per_primitive.
struct Budget {
  /// So many tests of pairs in a detection (give or take the last few hundred), the same ones on every run.
  std::optional<int> tests{};
  /// So many milliseconds in all detections of a time step; which contacts are found depends on the machine.
  std::optional<double> milliseconds{};
  std::optional<InterestRegion> region{};  ///< tested before others that are as near
  friend bool operator==(const Budget&, const Budget&) = default;
};

/// How contacts are found.
struct DetectionSettings {
  Structure structure = Structure::compact;      ///< spatial data structure of the broad phase
  Order order = Order::linear;                   ///< numbering of cells
  Sort sort = Sort::adaptive;                    ///< of the entries; Structure::compact only
  CellSize cell_size = CellSizeRule::automatic;  ///< m, or the rule that chooses it
  /// Slots of a primitive for the cells that it covers, 1 to 27 (approximate mode, paper 5); none: exact.
  std::optional<int> cells_per_primitive;
  /// Per body: 1 where a body that can move also touches itself. Empty: none does.
  std::vector<std::uint8_t> self_collision;
  /// Pairs of two different bodies, in any order, that are not tested against each other. A list of all
  /// n_bodies^2 / 2 pairs is allowed, but each pair of a point and a tet that meet is looked up in it.
  std::vector<std::array<Index, 2>> ignored_pairs{};
  /// Whether surface edges that pass through a body with both ends outside are found (docs/edges.md).
  /// Without, contacts are those of the paper: bodies that cross edge on edge go through each other unseen.
  bool edge_contacts = true;
  /// Whether frames in which little moves since earlier ones gain from these. Contacts do not depend on it.
  /// Only Structure::compact without cells_per_primitive and budget can.
  bool coherence = true;
  /// Whether a simulation searches for parts that would pass through another body within a step
  /// (docs/continuous.md), and stops them at the first touch. A step that stops many takes many solves. If
  /// false, pairs of bodies that could pass are only counted.
  bool continuous = false;
  std::optional<Budget> budget{};  ///< none: all contacts, however long it takes
  friend bool operator==(const DetectionSettings&, const DetectionSettings&) = default;
};

/// How contacts push back: a penalty force along the direction, friction across it (docs/architecture.md,
/// "Forces").
struct ResponseSettings {
  /// Force per depth at each point in contact, N/m; none: from material and element size of the two bodies.
  std::optional<double> stiffness;
  /// Damping along the direction, as a fraction of the critical damping of the point on its penalty spring;
  /// >= 0.
  double damping = 0.3;
  double friction = 0.0;  ///< Coulomb coefficient, >= 0
};

/// How a step is solved.
struct SolverSettings {
  double tolerance = 1e-4;                                    ///< at which the conjugate gradients stop, > 0
  ToleranceOf tolerance_of = ToleranceOf::solution;           ///< what `tolerance` is relative to
  Preconditioner preconditioner = Preconditioner::automatic;  ///< affects convergence only
  int max_iterations = 300;                                   ///< cap; reaching it is counted in the metrics
  /// So many iterations in each solve, whatever the tolerance, for steps that take the same time; none: as
  /// many as it asks for. > 0.
  std::optional<int> fixed_iterations{};
  /// Cap of the solves of a step. Bodies that meet, or rotate fast, need more than one.
  int max_solves = 40;
};

/// When bodies count as at rest: the root mean square speed (by mass) of each has been at most `speed` for
/// `time` without a break, so that the first steps of a fall do not count. One point that trembles on a rim
/// does not prevent rest; a body that moves does.
struct RestSettings {
  double speed = 1e-3;  ///< m/s
  double time = 0.05;   ///< s
};

/// When a run has blown up and stops with an Error; a value that is not finite always stops it.
struct LimitSettings {
  /// m/s, > 0; no point may be faster. None: 100 diagonals of the box of all points at the start, per time
  /// step, and what a free fall adds.
  std::optional<double> max_speed{};
  /// s, > 0; a tet that has been inverted (volume <= 0) for so long without a break stops the run. None: no
  /// limit, since elastic forces restore inverted tets (docs/inversion.md).
  std::optional<double> inverted_time{};
};

/// Everything of a simulation that is not a body.
struct SimulationSettings {
  double time_step = 0.01;        ///< s, > 0
  Vec3 gravity{0.0, 0.0, -9.81};  ///< m/s^2
  DetectionSettings detection;    ///< how contacts are found
  ResponseSettings response;      ///< how contacts push back
  SolverSettings solver;          ///< how a step is solved
  RestSettings rest;              ///< when bodies count as at rest
  LimitSettings limits;           ///< when a run has blown up
};

}  // namespace palpate
