#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <palpate/mesh.hpp>

#include "scene/scene.hpp"

namespace palpate {

/// The length unit of a mesh file.
struct MeshUnit {
  std::string name;     ///< "m", "cm", "mm" or "um"; empty if none fits
  double meters = 1.0;  ///< > 0
};

/// The unit of that name, if there is one.
std::optional<MeshUnit> mesh_unit(std::string_view name);

/// The unit that a mesh is probably in, guessed from its longest side, because mesh files do not name it: the
/// first of m, mm, cm and um that gives the size of an organ or a limb. If none fits, as for a unit cube, a
/// unit without a name that makes the mesh 0.1 m long.
MeshUnit guess_unit(double longest_side);

/// Options of the first scene of a mesh.
struct FirstSceneOptions {
  double meters = 1.0;  ///< length of a unit of the mesh, > 0
  bool drop = false;    ///< true: the body falls onto the floor; false: its lowest tenth is fixed
};

/// Young's modulus of the body of a first scene that hardly sags, Pa; others are stiffer.
constexpr double softest_first_body = 20e3;

/// A first scene in SI units, with size and mass of its body.
struct FirstScene {
  Scene scene;
  Vec3 size;    ///< of the body's box, m
  double mass;  ///< kg
};

/// Makes a scene of one soft body under gravity that a rigid instrument presses at the end. Either the body's
/// lowest tenth is held (if it has several pieces, that of each). Then a ball with a prescribed motion comes
/// down where it meets the body first, presses it by at most a seventh of its height, and stays. Or the body
/// falls onto a floor; when it is at rest, a plate comes down until it presses by twice the weight of the
/// body (in stages, since it is not known beforehand how the body will lie). The stiffness is chosen so that
/// the body keeps its shape: at least 20 kPa, and more if it would sag by more than 1/200 of its height on
/// average. Numbers are rounded to what a person would write: positions to at most 1e-5 of the longest side.
///
/// \param name  of the scene and the body
/// \param file  path of the mesh file in the scene
/// \param mesh  its points and tets, checked; in units of the file
///
/// Throws Error if the length of a unit is not positive, or the mesh is refused. O(n log n), and a step of a
/// simulation.
FirstScene make_first_scene(const std::string& name, const std::string& file, const TetMesh& mesh,
                            const FirstSceneOptions& options);

}  // namespace palpate
