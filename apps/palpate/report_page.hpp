#pragma once

#include <string>

#include "run_report.hpp"

namespace palpate::app {

/// A page about a run, as one HTML file without external parts: warnings, outcomes at the end and by stage,
/// pictures of the end and of stages, forces, meshes, settings, versions and hashes. It contains the pictures
/// that exist in the folder.
std::string report_page(const RunReport& report);

}  // namespace palpate::app
