#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

#include "scene/scene.hpp"
#include "view/command.hpp"
#include "view/surface.hpp"

namespace palpate::view {

/// The phases of a step whose times are sent, in the order in which they run; the last is the whole step.
inline constexpr std::array<std::string_view, 8> phase_names{"grid",  "contacts", "border edges", "crossings",
                                                             "depth", "forces",   "solver",       "step"};
using PhaseSeconds = std::array<double, phase_names.size()>;

/// The page that sent a command.
using Client = std::uint64_t;

/// Data on the bodies that are the same for all frames.
// What clang-tidy sees thrown in a move is an assertion of nlohmann's.
struct Stage {                   // NOLINT(bugprone-exception-escape)
  nlohmann::ordered_json about;  ///< for the page: title, units, bodies, ...
  Vec3 origin{};  ///< positions are sent relative to it, because float32 is more accurate near zero
};

/// The data that pages display: a running simulation, or stored frames. Used by one thread.
class Source {
 public:
  Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;
  virtual ~Source() = default;

  [[nodiscard]] virtual const Stage& stage() const = 0;
  [[nodiscard]] virtual const Bodies& bodies() const = 0;
  [[nodiscard]] virtual std::span<const Vec3> positions() const = 0;
  [[nodiscard]] virtual const Detector& detector() const = 0;  ///< contacts at positions()
  [[nodiscard]] virtual double time() const = 0;               ///< simulated time, in the unit of the scene
  /// Simulated time between this state and the next; none at the end.
  [[nodiscard]] virtual std::optional<double> interval() const = 0;
  /// Advances to the next state. Throws Error if it cannot.
  virtual void advance() = 0;
  /// Returns to the start.
  virtual void reset() = 0;
  /// Times of the phases of the last advance().
  [[nodiscard]] virtual const PhaseSeconds& seconds() const = 0;
  /// Counts of the state, for the page.
  [[nodiscard]] virtual nlohmann::ordered_json counts() const = 0;
  /// For each body the wrench of its contacts (wrenches_json()), and as "held" its reaction if known; empty
  /// if nothing is known.
  [[nodiscard]] virtual nlohmann::ordered_json forces() const { return nlohmann::ordered_json::array(); }
  /// (n_points) numbers of a field, by the name of its ColourField; empty where this source does not have it.
  [[nodiscard]] virtual std::vector<double> field(const std::string& /*name*/) const { return {}; }
  /// How many stages of a plan have begun (docs/stages.md): each may change settings().
  [[nodiscard]] virtual std::size_t begun_stages() const { return 0; }
  /// The current values of settings that can be changed.
  [[nodiscard]] virtual nlohmann::ordered_json settings() const = 0;

  /// Each applies a command. Throws Error, and changes nothing, if this source cannot do it.
  virtual void apply(Client client, const Change& change) = 0;
  virtual void apply(Client client, const Pull& pull) = 0;
  virtual void apply(Client client, const MovePull& pull) = 0;
  virtual void apply(Client client, const LetGo& pull) = 0;
  virtual void apply(Client client, const DriveMotion& command) = 0;
  virtual void apply(Client client, const ResumeMotion& command) = 0;
  virtual void apply(Client client, const Seek& seek) = 0;
  /// Called when a page is closed: releases its pulls.
  virtual void forget(Client client) = 0;
};

/// Name, ranges and colour of each body, for Stage::about.
nlohmann::ordered_json bodies_json(const Bodies& bodies, const Surface& surface, const Scene& scene);

/// Entries of Stage::about that every source has.
nlohmann::ordered_json about_json(const Scene& scene, const nlohmann::ordered_json& bodies, double diagonal);

/// The counts of a detection, for Source::counts().
nlohmann::ordered_json detection_json(const DetectionCounts& counts);

/// Centre and diagonal of the box of all points. O(points).
struct Extent {
  Vec3 center;
  double diagonal;
};
Extent extent_of(std::span<const Vec3> positions);

}  // namespace palpate::view
