#include "companion_program.hpp"

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

int run_companion(const Companion& companion, std::span<const char* const> arguments) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename(companion.program).string();
  std::error_code ignored;
  if (!std::filesystem::exists(program, ignored)) {
    throw BadInput(std::string(companion.words), "", fmt::format("no '{}'", program),
                   std::string(companion.needs));
  }
  std::vector<std::string> words{fmt::format("palpate {}", companion.words)};
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
