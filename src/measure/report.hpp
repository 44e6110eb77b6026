#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "measure/section.hpp"

namespace palpate::measure {

/// A section of a report, and how it is measured.
struct Item {
  std::string_view id;
  std::function<Section()> measure;
};

/// 1, 2, 4 … threads, up to all of the machine.
std::vector<int> thread_counts();

/// A report: kind ("paper", "peers", "scaling"), machine, compiler, commit, settings, the date, UTC, and the
/// greatest load of the machine (processes that want to run, mean of a minute) after an item. Not complete
/// until measure_items has measured all.
/// \param effort  "quick" or "full"
nlohmann::ordered_json report_of(std::string_view kind, std::string_view effort);

/// What an item may throw in its midst where it is interrupted; measure_items says what there is by then.
struct Interrupted {};

/// Measures the items one after the other into report["sections"]; reports each when it is done, and writes
/// what there is so far to the file, so that who ends it early keeps what was measured; report["complete"] is
/// true with the last one. `interrupted` is asked before each item: where it says yes, throws
/// std::runtime_error.
void measure_items(nlohmann::ordered_json& report, const std::vector<Item>& items,
                   const std::filesystem::path& file,
                   const std::function<void(const std::string& line)>& tell,
                   const std::function<bool()>& interrupted);

}  // namespace palpate::measure
