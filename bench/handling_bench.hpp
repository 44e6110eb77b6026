#pragma once

#include <nlohmann/json.hpp>

#include "measure/query_scenes.hpp"

namespace palpate::bench {

/// All that a detection does (contacts, border edges, crossings, depths) beside finding the contacts, with
/// and without coherence, frame after frame: medians in ms.
nlohmann::json measure_handling(const measure::QueryScene& scene, std::uint32_t frames);

}  // namespace palpate::bench
