#pragma once

#include <span>
#include <string_view>

#include "io/vtu_structure.hpp"

namespace palpate::io {

/// Whether this build has a compressor of VTK's files. There are two builds of these functions: one by VTK's
/// own classes for the command (uncompress_vtk.cpp: all of them) and one by zlib for what has no VTK
/// (uncompress_zlib.cpp: ZLib, what VTK and most others write).
bool can_uncompress(VtuStructure::Compressor compressor);

/// Fills `target` with the bytes that `block` holds; false where the block is damaged or holds another number
/// of bytes. O(block + target).
bool uncompress(VtuStructure::Compressor compressor, std::string_view block, std::span<char> target);

}  // namespace palpate::io
