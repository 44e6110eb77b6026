#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "anatomy/stuffing.hpp"

/// The shapes of the eye's organs. Slender organs and skin keep a distance of `gap` (mm) from neighbours.
namespace palpate::anatomy {

/// Gap between organs that are meshed separately, mm: more than the distance of chords from a curved surface.
inline constexpr double eye_gap = 0.2;
inline constexpr double orbit_floor_thickness = 2.0;
inline constexpr double eye_plate_thickness = 0.8;
inline constexpr double eye_plate_cell = 1.9;
inline constexpr std::array<int, 2> eye_plate_cells{9, 11};
inline constexpr Vec3 eye_plate_start{-0.5 * 9 * eye_plate_cell, -2.0, 0.0};
/// Names of the recti, and their angles around the axis of the orbit, degrees.
inline const std::vector<std::pair<std::string, double>> eye_recti{
    {"rectus-lateral", 0.0}, {"rectus-superior", 90.0}, {"rectus-medial", 180.0}, {"rectus-inferior", 270.0}};

/// The bulb with the bulge of the cornea.
Distance bulb_shape();
/// The inside of the bony orbit: a cone that narrows to the apex, with a floor that rises to the back.
Distance cavity_shape();
Distance bone_shape();
/// The bone over a maxillary sinus, with a floor of the orbit as thick as `orbit_floor_thickness`.
Distance orbit_bone_shape();
/// Where the floor of the orbit is: a layer of the thickness `orbit_floor_thickness` below the cavity, from
/// the rim to the back.
Distance orbit_floor_shape();
/// The height at (x, y) that is `above` mm over the floor of the orbit.
double over_orbit_floor(double x, double y, double above);
/// A rectus that lies on the bulb and runs to the apex; `angle` (degrees) is where it lies around the axis of
/// the orbit.
Distance rectus_shape(double angle, double gap);
Distance nerve_shape(double gap);
/// The surface below the skin: bulb and bones, with the hollow between them filled.
Distance under_skin_shape();
Distance skin_shape(double gap);

}  // namespace palpate::anatomy
