#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <palpate/settings.hpp>
#include <palpate/types.hpp>

/// Commands of a page: a JSON object with one key, the name of the command, and its arguments as an object:
/// {"pull": {"vertex": 17, "target": [0, 0, 1]}}. Positions are relative to the origin that was sent to the
/// page, vertices are the vertices of Surface. docs/viewer-server.md lists all commands.
namespace palpate::view {

struct Play {
  bool on = true;
};
struct StepOnce {};
struct Reset {};
/// Largest ratio of simulated time to clock time; none: as fast as possible.
struct SetSpeed {
  std::optional<double> speed;
};
/// New settings from the page; absent ones stay.
struct Change {
  nlohmann::json settings = nlohmann::json::object();
};
/// Pulls a vertex by a spring; replaces the pull of this page before it.
struct Pull {
  Index vertex = -1;
  Vec3 target{};
  double strength = 1.0;  ///< relative to the usual stiffness
};
struct MovePull {
  Vec3 target{};
};
struct LetGo {};
/// Moves a body with a prescribed motion: to a time of its path, or by an offset from the path.
struct DriveMotion {
  Index motion = -1;
  std::optional<double> time;
  std::optional<Vec3> offset;
};
/// Lets a prescribed motion continue in time, from its position on the path.
struct ResumeMotion {
  Index motion = -1;
};
struct Seek {
  Index frame = 0;
};
/// The data that the page needs beside the positions.
struct DisplayOptions {
  bool contacts = false;
  bool borders = false;
  bool cells = false;
  bool inside = false;  ///< also inner points: their positions and their values of fields
  bool forces = false;  ///< contact forces on each body
  std::vector<std::string>
      fields{};  ///< names of fields, sent as a number for each vertex; for vectors the length
  friend bool operator==(const DisplayOptions&, const DisplayOptions&) = default;
};
/// The page has drawn a frame and can take another.
struct Shown {
  double frame = 0.0;
};

using Command = std::variant<Play, StepOnce, Reset, SetSpeed, Change, Pull, MovePull, LetGo, DriveMotion,
                             ResumeMotion, Seek, DisplayOptions, Shown>;

/// Longer messages are refused without parsing.
inline constexpr std::size_t longest_message = 4096;

/// Throws Error "message from the page: ..." on anything but a command. O(length).
Command parse_command(std::string_view text);

/// The settings that Change can name, as JSON.
nlohmann::ordered_json settings_json(const SimulationSettings& settings);

/// `settings` with the values of a Change; throws Error naming the key of a refused value.
SimulationSettings changed(const SimulationSettings& settings, const nlohmann::json& change);

}  // namespace palpate::view
