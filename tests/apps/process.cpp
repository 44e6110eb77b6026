#include "apps/process.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "results/support.hpp"

namespace palpate::test {
namespace {

constexpr auto longest = std::chrono::seconds(PALPATE_LONGEST_SECONDS);
constexpr auto pause = std::chrono::milliseconds(2);

/// In the child: becomes the command.
[[noreturn]] void become(std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  // A test in the background of a shell ignores SIGINT, and the child would inherit that.
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  if (::chdir(folder.c_str()) != 0) ::_exit(126);
  std::vector<char*> words;
  for (std::string& word : arguments) words.push_back(word.data());
  words.push_back(nullptr);
  ::execv(PALPATE_COMMAND, words.data());
  ::_exit(127);
}

void redirect(const std::filesystem::path& file, int descriptor) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  ::dup2(opened, descriptor);
  ::close(opened);
}

std::filesystem::path output_file(const std::filesystem::path& folder, const char* extension) {
  static std::atomic<int> counter{0};
  return folder.string() + "." + std::to_string(counter.fetch_add(1)) + extension;
}

}  // namespace

Process::Process(std::vector<std::string> arguments, const std::filesystem::path& folder,
                 const std::filesystem::path& device)
    : out_(output_file(folder, ".out")), err_(output_file(folder, ".err")) {
  arguments.insert(arguments.begin(), "palpate");
  pid_ = ::fork();
  if (pid_ != 0) return;
  if (device == closed_streams) {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::close(stream);
    become(arguments, folder);
  }
  redirect("/dev/null", STDIN_FILENO);
  redirect(device.empty() ? out_ : device, STDOUT_FILENO);
  redirect(err_, STDERR_FILENO);
  become(arguments, folder);
}

Process::~Process() {
  if (running()) {
    send(SIGKILL);
    ::waitpid(pid_, &status_, 0);
  }
  std::filesystem::remove(out_);
  std::filesystem::remove(err_);
}

void Process::send(int signal) const {
  ::kill(pid_, signal);
}

bool Process::running() {
  if (!ended_) ended_ = ::waitpid(pid_, &status_, WNOHANG) == pid_;
  return !ended_;
}

bool Process::handles(int signal) const {
  const std::string status = content_of("/proc/" + std::to_string(pid_) + "/status");
  const std::string name = "SigCgt:";
  const std::size_t at = status.find(name);
  if (at == std::string::npos) return false;
  return (std::stoull(status.substr(at + name.size()), nullptr, 16) >> (signal - 1) & 1U) != 0;
}

Finished Process::wait() {
  const auto deadline = std::chrono::steady_clock::now() + longest;
  while (running()) {
    if (std::chrono::steady_clock::now() > deadline) {
      ADD_FAILURE() << "the command did not end";
      send(SIGKILL);
    }
    std::this_thread::sleep_for(pause);
  }
  Finished finished;
  if (WIFEXITED(status_)) finished.exit_code = WEXITSTATUS(status_);
  if (WIFSIGNALED(status_)) finished.signal = WTERMSIG(status_);
  finished.out = content_of(out_);
  finished.err = content_of(err_);
  return finished;
}

void wait_until(const std::function<bool()>& reached) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!reached()) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    std::this_thread::sleep_for(pause);
  }
}

Finished palpate(std::vector<std::string> arguments, const std::filesystem::path& folder) {
  return Process(std::move(arguments), folder).wait();
}

std::string palpate_on_terminal(std::vector<std::string> arguments, const std::filesystem::path& folder,
                                int columns, const std::string& typed) {
  arguments.insert(arguments.begin(), "palpate");
  const winsize size{
      .ws_row = 24, .ws_col = static_cast<unsigned short>(columns), .ws_xpixel = 0, .ws_ypixel = 0};
  int terminal = -1;
  const pid_t pid = ::forkpty(&terminal, nullptr, nullptr, &size);
  if (pid == 0) become(arguments, folder);
  EXPECT_EQ(::write(terminal, typed.data(), typed.size()), static_cast<ssize_t>(typed.size()));
  std::string text;
  std::array<char, 4096> bytes{};
  for (ssize_t count = 0; (count = ::read(terminal, bytes.data(), bytes.size())) > 0;) {
    text.append(bytes.data(), static_cast<std::size_t>(count));
  }
  ::close(terminal);
  ::waitpid(pid, nullptr, 0);
  return text;
}

}  // namespace palpate::test
