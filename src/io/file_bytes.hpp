#pragma once

#include <filesystem>
#include <string>

namespace palpate::io {

/// Throws Error unless the path is an existing regular file: reading a folder fails late, and reading a pipe
/// or a device may never end. Throws for a pointer of git-LFS too, which is no file of its format.
///
/// \param expected  what should have been there, for the message ("a Gmsh mesh file")
void require_regular_file(const std::filesystem::path& path, const std::string& expected);

/// The bytes of a file. Throws Error if there is no such file, it is a folder, empty, a pointer of
/// git-LFS, or may not be read.
///
/// \param expected  what should have been there, for the message ("a Gmsh mesh file")
std::string read_file(const std::filesystem::path& path, const std::string& expected);

}  // namespace palpate::io
