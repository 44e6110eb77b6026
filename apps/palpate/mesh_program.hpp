#pragma once

#include <span>
#include <string_view>

namespace palpate::app {

/// The subcommand that is a program of its own: it contains CGAL, which is GPL, and this command does not.
inline constexpr std::string_view mesh_subcommand = "mesh";

/// Becomes palpate-mesh, which lies beside this program, with these arguments; does not return. Throws
/// BadInput where it is not there.
int run_mesh_program(std::span<const char* const> arguments);

}  // namespace palpate::app
