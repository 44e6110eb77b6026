#pragma once

#include <string>

#include <palpate/model.hpp>

#include "scene/first_scene.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// Warns of the soft body whose size or mass is furthest from that of tissue: longer than 5 m, shorter than
/// 0.2 mm, or over 2 tonnes. Usually its mesh has other units than the scene.
void warn_of_sizes(const Scene& scene, const Model& model);

/// Warns of a mesh that is longer than 5 m or shorter than 0.2 mm.
/// \param side  its longest side, in `unit`
void warn_of_size(const std::string& file, double side, const MeshUnit& unit);

/// A length in metres for people: "0.21 m", "3.5 mm".
std::string length_text(double meters);
/// A mass in kilograms for people: "1.4 kg", "12 g", "38 tonnes".
std::string mass_text(double kilogrammes);

}  // namespace palpate::app
