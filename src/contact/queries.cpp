// The queries of each structure.
#include <memory>

#include <palpate/error.hpp>

#include "contact/cell_crossings.hpp"
#include "contact/cell_points.hpp"
#include "contact/clustered_crossings.hpp"
#include "contact/clustered_points.hpp"
#include "grid/brute.hpp"
#include "grid/compact.hpp"
#include "grid/cuckoo.hpp"
#include "grid/hash.hpp"
#include "grid/uniform.hpp"

namespace palpate {
namespace {

/// Calls make(structure) with an empty structure of the settings.
template <class Make>
auto with_structure(const DetectionSettings& settings, Make&& make) {
  switch (settings.structure) {
    case Structure::uniform:
      return make(UniformGrid(settings.order));
    case Structure::compact:
      return make(CompactGrid(settings.order, settings.sort));
    case Structure::hash:
      return make(HashGrid());
    case Structure::cuckoo:
      return make(CuckooGrid(settings.order));
    case Structure::brute:
      return make(BruteForce());
  }
  throw Error("detection settings", "structure", std::to_string(static_cast<int>(settings.structure)),
              "a known structure");
}

}  // namespace

std::unique_ptr<PointQuery> make_point_query(const Bodies& bodies, const DetectionSettings& settings) {
  if (works_on_clusters(settings)) return std::make_unique<ClusteredPoints>(bodies, settings);
  return with_structure(settings, []<class S>(S structure) -> std::unique_ptr<PointQuery> {
    return std::make_unique<CellPoints<S>>(std::move(structure));
  });
}

std::unique_ptr<CrossingQuery> make_crossing_query(const Bodies& bodies, const DetectionSettings& settings) {
  if (works_on_clusters(settings)) return std::make_unique<ClusteredCrossings>(bodies, settings);
  return with_structure(settings, []<class S>(S structure) -> std::unique_ptr<CrossingQuery> {
    return std::make_unique<CellCrossings<S>>(std::move(structure));
  });
}

}  // namespace palpate
