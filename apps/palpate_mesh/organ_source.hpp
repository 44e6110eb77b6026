#pragma once

#include <string>
#include <vector>

#include "mesh_options.hpp"
#include "organ.hpp"

namespace palpate::app {

/// A label that is in a map, with its name.
struct NamedLabel {
  LabelExtent extent;
  LabelName name;
};

/// A label map and the labels of it to mesh.
struct NamedMap {
  LabelMap map;
  std::vector<NamedLabel> labels;  ///< ascending; names are unique
  std::vector<std::string> warnings;
};

/// Reads a label map; numbers of labels in the flags become their names. Throws Error if the file is
/// refused, and BadInput if a flag names an organ that is not there.
NamedMap read_named_map(MeshOptions& options);

/// Converts a frame in LPS to RAS where `ras` is true.
Frame in_space(Frame frame, bool ras);

/// The organs to mesh, and remarks on the input.
struct OrganList {
  std::vector<Organ> organs;  ///< in the order of labels or files; names are unique
  std::vector<std::string> warnings;
};

/// Reads the input and shapes its organs; numbers of labels in the flags become their names. Throws Error
/// if a file is refused, and BadInput if a flag names an organ that is not there.
OrganList read_organs(MeshOptions& options);

}  // namespace palpate::app
