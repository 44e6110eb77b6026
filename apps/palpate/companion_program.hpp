#pragma once

#include <span>
#include <string_view>

namespace palpate::app {

/// A subcommand that is a separate program in the same folder. It links libraries that this command must not
/// link, such as CGAL (GPL), or that only benchmarks need.
struct Companion {
  std::string_view words;    ///< the words that call it, such as "mesh"
  std::string_view program;  ///< "palpate-mesh"
  std::string_view needs;    ///< what a build needs so that it includes the program
};

inline constexpr Companion mesh_companion{
    "mesh", "palpate-mesh", "a build where CGAL and ITK are installed (libcgal-dev, libinsighttoolkit5-dev)"};
inline constexpr Companion peers_companion{
    "bench peers", "palpate-bench-peers",
    "a build where CGAL, Bullet and TBB are installed (libcgal-dev, libbullet-dev, libtbb-dev)"};
inline constexpr Companion speed_companion{"bench speed", "palpate-bench-speed",
                                           "a build with the benchmarks (PALPATE_BUILD_BENCH)"};
inline constexpr Companion step_companion{"bench step", "palpate-bench-step",
                                          "a build with the benchmarks (PALPATE_BUILD_BENCH)"};

/// Replaces this process by the program (exec), with these arguments; does not return. Throws BadInput if
/// the program does not exist.
int run_companion(const Companion& companion, std::span<const char* const> arguments);

}  // namespace palpate::app
