#pragma once

#include <span>
#include <string_view>

#include "io/vtu_structure.hpp"

namespace palpate::io {

/// Whether this build supports a compressor of VTK's files. These functions have two implementations: with
/// VTK's classes for the command (uncompress_vtk.cpp: all compressors), and with zlib for builds without VTK
/// (uncompress_zlib.cpp: ZLib, which VTK and most programs write).
bool can_uncompress(VtuStructure::Compressor compressor);

/// Uncompresses `block` into `target`; false where the block is damaged or has another number of bytes.
/// O(block + target).
bool uncompress(VtuStructure::Compressor compressor, std::string_view block, std::span<char> target);

}  // namespace palpate::io
