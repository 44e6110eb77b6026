#pragma once

#include <filesystem>
#include <vector>

#include "label_map.hpp"

namespace palpate::app {

/// Reads names and colours of labels: a color table of 3D Slicer (.ctbl, .txt: "1 bone 241 214 145 255") or a
/// label description of ITK-SNAP (.label, .txt: `1 241 214 145 1 1 1 "bone"`). Lines that begin with # are
/// comments. Throws Error naming the file and line if a line is neither, or a label is named twice.
std::vector<LabelName> read_label_table(const std::filesystem::path& path);

}  // namespace palpate::app
