#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace palpate::test {

/// How a process ended and what it wrote.
struct Finished {
  int exit_code = -1;  ///< -1 where a signal ended it
  int signal = 0;      ///< the signal that ended it
  std::string out;
  std::string err;
};

/// Closes all standard streams of a Process, as a shell's "<&- >&- 2>&-".
inline constexpr const char* closed_streams = "closed";

/// The palpate command, started in a folder. Its output goes to files beside that folder.
class Process {
 public:
  /// \param folder  its current folder
  /// \param device  receives stdout instead of a file ("/dev/full"; the text is lost); or closed_streams
  Process(std::vector<std::string> arguments, const std::filesystem::path& folder,
          const std::filesystem::path& device = {});
  /// Kills it if it still runs.
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const;
  [[nodiscard]] bool running();
  /// Whether it has its own handler for a signal (/proc, Linux).
  [[nodiscard]] bool handles(int signal) const;
  /// Waits for its end; fails the test and kills it after two minutes.
  Finished wait();

 private:
  std::filesystem::path out_;
  std::filesystem::path err_;
  pid_t pid_ = -1;
  int status_ = 0;
  bool ended_ = false;
};

/// Waits until this is true; fails the test after a minute.
void wait_until(const std::function<bool()>& reached);

/// Runs the command to its end.
Finished palpate(std::vector<std::string> arguments, const std::filesystem::path& folder);

/// Runs the command on a terminal of this width with `typed` as input; returns the terminal's text, with the
/// echo.
std::string palpate_on_terminal(std::vector<std::string> arguments, const std::filesystem::path& folder,
                                int columns, const std::string& typed = "");

}  // namespace palpate::test
