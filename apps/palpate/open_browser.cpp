#include "open_browser.hpp"

#include <array>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

namespace palpate::app {

void open_browser(const std::string& address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  std::string command = "xdg-open";
  std::string argument = address;
  std::array<char*, 3> arguments{command.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t files{};
  posix_spawn_file_actions_init(&files);
  for (const int output : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, output, "/dev/null", O_WRONLY, 0);
  }
  ::signal(SIGCHLD, SIG_IGN);  // the child is not waited for
  pid_t child = 0;
  // Without xdg-open the user still has the printed address.
  static_cast<void>(posix_spawnp(&child, command.c_str(), &files, nullptr, arguments.data(), environ));
  posix_spawn_file_actions_destroy(&files);
}

}  // namespace palpate::app
