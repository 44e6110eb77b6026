#pragma once

#include <string>
#include <vector>

#include "mesh_options.hpp"
#include "organ.hpp"

namespace palpate::app {

/// The organs to mesh, and what is worth telling of the input.
struct OrganList {
  std::vector<Organ> organs;  ///< in the order of labels or files; names are unique
  std::vector<std::string> warnings;
};

/// Reads the input and shapes its organs; numbers of labels in the flags become their names. Throws Error
/// where a file is refused, and BadInput where a flag names an organ that is not there.
OrganList read_organs(MeshOptions& options);

}  // namespace palpate::app
