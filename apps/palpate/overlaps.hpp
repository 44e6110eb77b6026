#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>

#include "scene/coarse_pairs.hpp"
#include "scene/overlaps.hpp"

namespace palpate::app {

nlohmann::ordered_json overlaps_json(const Bodies& bodies, const std::vector<Overlap>& list);
/// A line for each of the deepest pairs, then the number of others; empty if there are no overlaps.
std::string overlaps_text(const Bodies& bodies, std::vector<Overlap> list, const std::string& length_unit);

/// A line for scenes without edge contacts (DetectionCounts::unseen_pairs).
std::string unseen_pairs_text(std::size_t pairs);

nlohmann::ordered_json coarse_pairs_json(const Bodies& bodies, const std::vector<CoarsePair>& list);
/// A line for each of the worst pairs, then the number of others; empty if there are none.
std::string coarse_pairs_text(const Bodies& bodies, const std::vector<CoarsePair>& list,
                              const std::string& length_unit);

}  // namespace palpate::app
