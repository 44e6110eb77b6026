#pragma once

#include <string>
#include <vector>

#include <palpate/mesh.hpp>

/// The organs of the paper's medical scenes, made of signed distances without any external data. Lengths in
/// mm; x to the left, y to the back, z up, as in the LPS frame of medical images. docs/anatomy.md has
/// pictures.
namespace palpate::anatomy {

struct Organ {
  std::string name;  ///< of its file: "bulb", "lower-jaw"
  TetMesh mesh;
};

/// A left orbit around the bulb's centre at the origin: bone, fat, bulb, four recti, optic nerve, skin and a
/// perforated titanium plate on the orbital floor. Organs that touch are apart by about 0.2 mm.
std::vector<Organ> make_eye();

/// A face around the head's centre: skull, upper jaw, lower jaw with rami, and the soft tissue over them.
std::vector<Organ> make_skull();

}  // namespace palpate::anatomy
