#pragma once

#include <filesystem>
#include <vector>

#include "peers/peer.hpp"

namespace palpate::bench {

/// Where the peers in Python are: an interpreter that has their packages, and the program that calls them.
struct PythonPeers {
  std::filesystem::path python;
  std::filesystem::path program;
};

/// Starts the program for each peer; those that say they cannot are absent.
void add_python(const PythonPeers& python, const Course& course, const std::vector<int>& threads,
                std::vector<Entrant>& entrants, std::vector<Absentee>& absent);

}  // namespace palpate::bench
