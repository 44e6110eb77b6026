#pragma once

#include <string>

#include "mesh_options.hpp"

namespace palpate::app {

/// Throws BadInput if the flags do not fit each other.
void check_mesh_options(const MeshOptions& options);

/// The name of the input: the file name of the first without folder and extensions (".seg.nrrd", ".nii.gz").
std::string input_name(const MeshOptions& options);

}  // namespace palpate::app
