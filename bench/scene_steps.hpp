#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <palpate/simulation.hpp>

namespace palpate::bench {

/// The simulation of a scene file, with another budget than it names. Overlaps are removed first where the
/// scene asks for it. Throws Error as readers do.
Simulation simulation_of(const std::filesystem::path& scene_file, const std::optional<Budget>& budget,
                         int threads);

/// (n_bodies) 1 for each body of a scene that is rigid.
std::vector<std::uint8_t> rigid_bodies_of(const std::filesystem::path& scene);

/// The motions of a scene, as it has them.
std::vector<Motion> motions_of(const std::filesystem::path& scene);

/// Number of times that the system has suspended this thread for another since it began.
std::int64_t preemptions();

}  // namespace palpate::bench
