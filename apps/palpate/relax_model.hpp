#pragma once

#include <optional>

#include <palpate/model.hpp>
#include <palpate/relax.hpp>

#include "interrupt.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// Removes the overlaps at the start where the scene asks for it, and prints on stderr which overlaps are
/// left. An interrupt ends it with an exception. Throws BadInput for errors in the scene.
std::optional<RelaxReport> relax_model(const Scene& scene, Model& model, int threads, bool quiet,
                                       const InterruptFlag& interrupt);

}  // namespace palpate::app
