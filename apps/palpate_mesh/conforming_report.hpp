#pragma once

#include <string>
#include <vector>

#include "conforming_output.hpp"

namespace palpate::app {

/// A body and its file in the folder.
struct BodyFile {
  std::string name;
  std::string file;
};

/// The tissue that has the most voxels of a body.
int main_tissue(const TissueBody& body, const NamedMap& map);

/// The report on a mesh whose bodies were written to these files.
ConformingReport conforming_report(const ConformingMesh& made, const std::vector<BodyFile>& files,
                                   const NamedMap& map, const TissuePlan& plan);

}  // namespace palpate::app
