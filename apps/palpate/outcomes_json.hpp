#pragma once

#include <nlohmann/json.hpp>

#include "run_report.hpp"

namespace palpate::app {

/// The content of outcomes.json: for each outcome its value at the end, unit, definition, and values at the
/// ends of stages.
nlohmann::ordered_json outcomes_json(const RunReport& report);

/// The completed stages of a run, for run.json and outcomes.json.
nlohmann::ordered_json stages_json(const RunReport& report);

}  // namespace palpate::app
