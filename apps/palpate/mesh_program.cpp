#include "mesh_program.hpp"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <system_error>
#include <unistd.h>
#include <vector>

#include <palpate/error.hpp>

#include "exit_codes.hpp"

namespace palpate::app {

int run_mesh_program(std::span<const char* const> arguments) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("palpate-mesh").string();
  std::error_code ignored;
  if (!std::filesystem::exists(program, ignored)) {
    throw BadInput("mesh", "", fmt::format("no '{}'", program),
                   "a build where CGAL and ITK are installed (libcgal-dev, libinsighttoolkit5-dev)");
  }
  std::vector<std::string> words{"palpate mesh"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  throw Error(program, "", fmt::format("'{}'", std::system_category().message(errno)),
              "a program that can be started");
}

}  // namespace palpate::app
