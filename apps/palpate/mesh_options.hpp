#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::app {

/// The fineness of the meshes: a size, or a number of tets for which the size is searched.
struct Fineness {
  struct Named {
    std::string organ;
    double value;
  };
  double size = 0.0;              ///< of surface triangles, mm; 0: chosen by the number of tets
  std::vector<Named> sizes;       ///< for organs with a size of their own
  double tets = 0.0;              ///< number of tets of all organs together that have no number of their own
  double tets_each = 0.0;         ///< number of tets of each such organ, instead of `tets`
  std::vector<Named> named_tets;  ///< for organs with a number of their own
  double cell_ratio = 0.9;        ///< size of tets relative to that of triangles
  double distance_ratio = 0.14;   ///< distance of triangles from the surface, relative to their size
  std::size_t max_points = 2'000'000;  ///< of a mesh
};

/// How the shape of an organ is computed from voxels or a surface.
struct Shaping {
  double smoothing = 0.7;  ///< standard deviation of the blur, voxels; 0: none
  bool smoothing_given = false;
  double gap = 0.0;                   ///< between the surfaces of organs that touch, mm
  std::optional<double> close_holes;  ///< size of the largest holes of surfaces that are closed, mm; none:
                                      ///< relative to the surface
  double unit_millimeters = 1.0;      ///< length of a unit of the coordinates of surfaces
  bool unit_given = false;
};

/// The relation between two tissues that touch.
enum class Relation {
  grown,   ///< common points: one body, or soft tissue that is glued to a rigid one
  slides,  ///< two bodies in contact, with the same triangles on both sides
  open     ///< two bodies with a gap between them
};
inline constexpr std::array<std::string_view, 3> relation_names{"grown", "slides", "open"};

/// How one mesh of all labels is made and cut into bodies.
struct Conformity {
  struct Pair {
    std::string organs;  ///< "A:B"
    Relation relation;
  };
  /// A ball in which tets are small, in the axes of the meshes.
  struct Focus {
    Vec3 center;
    double radius = 0.0;  ///< mm
    double size = 0.0;    ///< mm
  };
  bool wanted = false;
  std::optional<Relation>
      general;  ///< of all pairs without a relation of their own; none: they are grown together
  std::vector<Pair> pairs{};
  std::vector<Focus> focuses{};
  std::vector<Fineness::Named> interface_sizes{};  ///< of "A:B", mm
};

/// The options of `palpate mesh`.
struct MeshOptions {
  std::vector<std::filesystem::path> inputs;    ///< one label map, or surfaces
  std::optional<std::filesystem::path> out;     ///< folder; none: a new one, named after the input
  std::optional<std::filesystem::path> labels;  ///< table of names
  std::vector<std::string> only;                ///< organs to mesh, by name or number; empty: all
  std::vector<std::string> rigid;               ///< organs that become obstacles
  Fineness fineness;
  Shaping shaping;
  Conformity conformity;
  bool replace = false;  ///< write over an existing scene
  bool ras = false;      ///< meshes in RAS instead of LPS
  bool json = false;
  bool quiet = false;
};

inline constexpr std::string_view mesh_description =
    "Makes bodies of a segmentation: a tet mesh for each label or closed surface, and a scene.";

/// Adds the flags and examples of `palpate mesh`, for its program and for the help of the command; they
/// change `options` when the command is parsed.
void add_mesh_options(CLI::App& app, MeshOptions& options);

}  // namespace palpate::app
