#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// `palpate bench speed`: our library compared with others, in parts that can be measured separately.
namespace palpate::bench {

using Json = nlohmann::ordered_json;

/// Options of all parts.
struct SpeedEffort {
  std::optional<int> frames;  ///< frames per figure (the median); none: the default of each part
  double most_tets = 1e300;   ///< larger scenes are left out
  std::filesystem::path scenes = "scenes";  ///< has stacking.json, eye.json, skull.json
  std::filesystem::path skull;              ///< has hq_skull.mesh and others; empty: none
  std::filesystem::path raptors;  ///< has raptorTetra_8418.vtu and raptorTetra_19409.vtu; empty: none

  [[nodiscard]] int frames_or(int usual) const { return frames.value_or(usual); }
};

/// A scene or kernel of a part.
struct Case {
  std::string name;
  double tets = 0.0;
  /// Throws Error if a result is wrong.
  std::function<Json()> measure;
};

struct Part {
  std::string_view name;  ///< of the file, too: "query"
  std::vector<Case> cases;
  /// The rows of the tables (rows.hpp) that some measured cases make.
  std::function<Json(const Json& cases)> rows;
};

Part query_part(const SpeedEffort& effort);         ///< points in tets, beside Embree
Part handling_part(const SpeedEffort& effort);      ///< border edges beside Embree; the whole of a detection
Part threads_part(const SpeedEffort& effort);       ///< detections and steps by the number of threads
Part movers_part(const SpeedEffort& effort);        ///< putting movers in order, beside std::sort
Part dynamics_part(const SpeedEffort& effort);      ///< a step's system and its solution, beside Eigen
Part step_part(const SpeedEffort& effort);          ///< whole steps, beside SOFA
Part tissue_part(const SpeedEffort& effort);        ///< a hyperelastic law beside the corotational one
Part instructions_part(const SpeedEffort& effort);  ///< instructions of kernels, without a clock
/// Measures the cases one after the other into head["cases"], and head["table"] of them. Each time the file
/// is rewritten, so that an interrupted run keeps its results.
/// \param head  of the file: what was measured where and when
Json run_part(const Part& part, Json head, const std::filesystem::path& file,
              const std::function<void(const std::string& line)>& tell);

}  // namespace palpate::bench
