#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "measure/section.hpp"

namespace palpate::measure {

/// A section of a report, and the function that measures it.
struct Item {
  std::string_view id;
  std::function<Section()> measure;
};

/// 1, 2, 4 … threads, up to the number of the machine.
std::vector<int> thread_counts();

/// A report: kind ("paper", "peers", "scaling"), machine, compiler, commit, settings, the date (UTC), and the
/// largest load average of the machine (one minute) after an item. It is incomplete until measure_items() has
/// measured all items.
/// \param effort  "quick" or "full"
nlohmann::ordered_json report_of(std::string_view kind, std::string_view effort);

/// Thrown by an item that is interrupted; measure_items() then reports what was measured before.
struct Interrupted {};

/// Measures the items one after the other into report["sections"]; prints each when it is complete, and
/// writes the report to the file after each, so that an early end keeps the results so far;
/// report["complete"] is true with the last one. Calls `interrupted` before each item, and throws
/// std::runtime_error where it returns true.
void measure_items(nlohmann::ordered_json& report, const std::vector<Item>& items,
                   const std::filesystem::path& file,
                   const std::function<void(const std::string& line)>& tell,
                   const std::function<bool()>& interrupted);

}  // namespace palpate::measure
