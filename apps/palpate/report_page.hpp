#pragma once

#include <string>

#include "run_report.hpp"

namespace palpate::app {

/// A page about a run, one file of HTML without anything outside of it: warnings, outcomes at the end and by
/// stage, pictures of the end and of stages, forces, meshes, settings, versions and hashes. Pictures are
/// those that there are in the folder.
std::string report_page(const RunReport& report);

}  // namespace palpate::app
