#include "messages.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <string>
#include <system_error>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

std::string one_line(std::string_view message) {
  std::string line(message);
  std::ranges::replace_if(
      line, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }, '?');
  return line;
}

void say(spdlog::level::level_enum level, const char* pattern, std::string_view message) {
  spdlog::logger logger("palpate", std::make_shared<spdlog::sinks::stderr_sink_st>());
  logger.set_pattern(pattern);
  logger.log(level, one_line(message));
  logger.flush();
}

}  // namespace

void say_error(std::string_view message) {
  say(spdlog::level::err, "palpate: %l: %v", message);
}

void say_note(std::string_view message) {
  say(spdlog::level::info, "palpate: %v", message);
}

void say_progress(std::string_view message) {
  say(spdlog::level::info, "%H:%M:%S %v", message);
}

void print_out(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw Error("stdout", "writing", "'" + std::system_category().message(errno) + "'",
                "room for the whole output");
  }
}

}  // namespace palpate::app
