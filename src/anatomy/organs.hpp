#pragma once

#include <string>
#include <vector>

#include <palpate/mesh.hpp>

/// The organs of the paper's medical scenes, made of signed distances without any external data. Lengths in
/// mm; x to the left, y to the back, z up, as in the LPS frame of medical images. docs/anatomy.md has
/// pictures.
namespace palpate::anatomy {

struct Organ {
  std::string name;  ///< also the name of its file: "bulb", "lower-jaw"
  TetMesh mesh;
};

/// A left orbit around the bulb's centre at the origin: bone, fat, bulb, four recti, optic nerve, skin and a
/// perforated titanium plate on the orbital floor. Organs that touch are apart by about 0.2 mm.
std::vector<Organ> make_eye();

/// A plate for the floor of the orbit of make_eye() and orbit_labels().
struct OrbitPlate {
  bool flat = false;  ///< as steep as the floor is in the middle, and lies on it; false: bent as the floor is
  double width = 17.0;     ///< along x, mm, in [4, 26]
  double length = 20.0;    ///< along y, mm, in [4, 30]
  double x = -2.0;         ///< of its middle, mm, in [-8, 8]
  double y = 7.0;          ///< of its middle, mm, in [0, 16]
  double thickness = 0.8;  ///< mm, in [0.2, 3]
  double above =
      0.6;  ///< height of its lower side over the floor, mm, in [0, 5]; for a flat plate the smallest height
};

/// Of cells of about 1.2 mm, so that the length is a multiple of their edge. Throws Error if an option is
/// out of range.
TetMesh make_orbit_plate(const OrbitPlate& options);

/// The instrument that holds tissue off the way of this plate: a sheet that is 0.8 mm over the plate and in
/// front of it, and ends below the floor beside and behind it. Throws Error if an option is out of range.
TetMesh make_orbit_retractor(const OrbitPlate& options);

/// A face around the head's centre: skull, upper jaw, lower jaw with rami, and the soft tissue over them.
std::vector<Organ> make_skull();

}  // namespace palpate::anatomy
