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

/// What a page may ask for: a JSON object with one key, the name of the command, and its arguments as an
/// object: {"pull": {"vertex": 17, "target": [0, 0, 1]}}. Positions are relative to the origin that the page
/// was told, vertices are those of Surface. docs/viewer.md lists all commands.
namespace palpate::view {

struct Play {
  bool on = true;
};
struct StepOnce {};
struct Reset {};
/// Simulated time per time of the clock, at most; none: as fast as it can.
struct SetSpeed {
  std::optional<double> speed;
};
/// What of a simulation can change while it runs, as the page says it; what is absent stays.
struct Change {
  nlohmann::json settings = nlohmann::json::object();
};
/// Pulls a vertex by a spring, in place of any the page held before.
struct Pull {
  Index vertex = -1;
  Vec3 target{};
  double strength = 1.0;  ///< times the usual stiffness
};
struct MovePull {
  Vec3 target{};
};
struct LetGo {};
/// Moves a body with a prescribed motion to a time of its path, or off the path by an offset.
struct DriveMotion {
  Index motion = -1;
  std::optional<double> time;
  std::optional<Vec3> offset;
};
/// Lets a prescribed motion run in time again, from where it is on its path.
struct ResumeMotion {
  Index motion = -1;
};
struct Seek {
  Index frame = 0;
};
/// What the page wants to be sent beside the positions.
struct DisplayOptions {
  bool contacts = false;
  bool borders = false;
  bool cells = false;
  bool forces = false;                ///< of contacts, on each body
  std::vector<std::string> fields{};  ///< by name, a number for each vertex; of a vector its length
  friend bool operator==(const DisplayOptions&, const DisplayOptions&) = default;
};
/// The page has drawn a frame: it can take another.
struct Shown {
  double frame = 0.0;
};

using Command = std::variant<Play, StepOnce, Reset, SetSpeed, Change, Pull, MovePull, LetGo, DriveMotion,
                             ResumeMotion, Seek, DisplayOptions, Shown>;

/// Longer messages are refused unread.
inline constexpr std::size_t longest_message = 4096;

/// Throws Error "message from the page: ..." on anything but a command. O(length).
Command parse_command(std::string_view text);

/// The settings that Change can name, as JSON.
nlohmann::ordered_json settings_json(const SimulationSettings& settings);

/// `settings` with what a Change names; throws Error naming the key of what is refused.
SimulationSettings changed(const SimulationSettings& settings, const nlohmann::json& change);

}  // namespace palpate::view
