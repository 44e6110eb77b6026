#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/model.hpp>
#include <palpate/relax.hpp>
#include <palpate/settings.hpp>
#include <palpate/types.hpp>

#include "scene/outcome.hpp"
#include "scene/parts.hpp"
#include "scene/stage.hpp"
#include "scene/units.hpp"

/// A scene as plain data, and its text form: JSON with comments, described in docs/scene.md and
/// docs/scene.schema.json.
namespace palpate {

/// One body of a scene.
struct SceneBody {
  std::string name;  ///< unique in the scene
  BodySource source;
  Transform transform;
  std::optional<Material> material;  ///< always set for a deformable body
  Vec3 velocity{};                   ///< of all free points at the start, m/s
  Vec3 angular_velocity{};           ///< added to it; about the centre of mass at the start, rad/s
  std::optional<Vec3> gravity{};     ///< replaces the gravity of the scene
  std::vector<Region> regions;       ///< with other materials; if a tet is in several, the last one counts
  std::optional<FibreEnds> fibre_ends{};  ///< replaces the fibre direction of the material
  std::vector<Fixation> fixed;            ///< fixed points: the union of these selections
  std::vector<Prescription> prescribed;
  bool absent = false;                ///< absent until a stage inserts it
  bool obstacle = false;              ///< rigid: its points move only with its motion
  bool self_collision = false;        ///< the body can be in contact with itself
  BodyNames no_contact{};             ///< other bodies that it has no contact with
  std::optional<SceneMotion> motion;  ///< makes the body rigid and moves it
  std::vector<Attachment> attached;
  std::vector<Load> loads;
  std::vector<SceneGrab> grabs;
  std::optional<std::array<double, 3>> color;  ///< red, green, blue in [0, 1]; none: the picture chooses
};

/// The camera of a picture; absent values are chosen so that the whole scene is visible.
struct Camera {
  std::optional<Vec3> position;
  std::optional<Vec3> target;
};
struct Picture {
  std::array<int, 2> size{1280, 720};  ///< width and height in pixels
  Camera camera;
};
/// A plane that cuts bodies open for a view: the side of `normal` is removed.
struct Cut {
  Vec3 point{};
  Vec3 normal{0.0, -1.0, 0.0};
  BodyNames bodies;  ///< bodies that are cut; empty: all
};
/// Colours bodies by the length of the displacement from rest.
struct DisplacementMap {
  double most = 1.0;  ///< end of the scale, > 0
  BodyNames bodies;   ///< bodies that are coloured; empty: deformable bodies
};
/// Names of fields, of field_list.hpp.
struct FieldNames {
  std::vector<std::string> names;
};
/// Colours bodies by a field at their points: its value, or the length of a vector.
struct FieldMap {
  std::string name{};
  double least = 0.0;            ///< start of the scale
  std::optional<double> most{};  ///< end of the scale; none: the largest value
  BodyNames bodies{};            ///< bodies that are coloured; empty: deformable bodies
};
/// A pair of bodies for which the force on each other is written.
struct BodyPair {
  BodyNames bodies;
};
/// The time of a view.
enum class ViewTime {
  end,    ///< at the end of the run
  start,  ///< at the start of the run, after overlaps were removed
  both    ///< both, side by side
};
inline constexpr std::array<std::string_view, 3> view_time_names{"end", "start", "both"};
/// A picture besides picture.png: NAME.png.
struct View {
  std::string name;
  std::array<int, 2> size{1280, 720};  ///< width and height in pixels
  Camera camera{};
  ViewTime when = ViewTime::end;
  BodyNames bodies{};  ///< bodies that are shown; empty: all
  std::optional<Cut> cut{};
  std::optional<DisplacementMap> displacement{};
  std::optional<FieldMap> field{};
  bool contacts = false;  ///< shows points in contact
};
/// The output settings of a run.
struct OutputSettings {
  int every = 10;       ///< steps from one frame file to the next
  FieldNames fields{};  ///< further fields of frames, besides displacement, velocity, contact and depth
  std::vector<BodyPair> pairs{};  ///< pairs of bodies with columns in forces.csv
  Picture picture;
  std::vector<View> views;
  bool report = false;  ///< write a page about the run, with pictures of the ends of stages
};

/// Whether a body is rigid.
inline bool is_rigid(const SceneBody& body) {
  return body.obstacle || body.motion;
}

/// All input of `palpate run`.
struct Scene {
  std::string name;
  Units units;
  /// The sides of the patient to which x, y and z point, such as "LPS" for left, posterior, superior. None:
  /// not a patient.
  std::optional<std::string> axes{};
  SimulationSettings settings;
  double duration = 1.0;               ///< simulated time, > 0
  std::optional<RelaxSettings> relax;  ///< removal of overlaps before a run; none: overlaps stay
  std::vector<SceneBody> bodies;
  std::vector<Stage> stages;           ///< in sequence; the duration is the sum of their limits
  std::vector<SceneOutcome> outcomes;  ///< quantities that a run determines
  OutputSettings output;
  std::string source;            ///< the file (or other origin) that errors name; not written to the text
  std::filesystem::path folder;  ///< mesh paths are relative to it; not written to the text
};

/// Reads a scene file; `changes`, each "KEY=VALUE" (scene/changes.hpp), replace its values. Throws Error:
/// file, line and column for what is not JSON, file and key path ("bodies[2].material.density") for an
/// unknown, repeated, missing, ill-typed or out-of-range value. Errors caused by a change name "--set" and
/// its text. Mesh files are not read. O(size of the file).
Scene read_scene(const std::filesystem::path& file, std::span<const std::string> changes = {});

/// Reads a scene from text; `source_name` stands for the file in errors, paths are relative to `base_folder`.
Scene read_scene_text(std::string_view text, std::string source_name, std::filesystem::path base_folder = {},
                      std::span<const std::string> changes = {});

/// The text form of a scene, with all settings (of bodies, only those that differ from the default). Reading
/// it gives the same scene, bit for bit. Throws Error if a number is NaN or infinite.
std::string write_scene(const Scene& scene);

/// A short text form to begin with: only what differs from the defaults, and what users change first (units,
/// times, gravity, friction, and of a material stiffness, Poisson's ratio and density). If the scene is not
/// in SI units, all settings are written, since the defaults are in SI.
std::string write_brief_scene(const Scene& scene);

}  // namespace palpate
