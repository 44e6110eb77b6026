#include "messages.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <string>
#include <system_error>
#include <unistd.h>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

std::string one_line(std::string_view message) {
  std::string line(message);
  std::ranges::replace_if(
      line, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }, '?');
  return line;
}

void say(const std::string& pattern, std::string_view message) {
  spdlog::logger logger("palpate", std::make_shared<spdlog::sinks::stderr_sink_st>());
  logger.set_pattern(pattern);
  logger.info(one_line(message));
  logger.flush();
}

bool shows_colours(int stream) {
  const auto given = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string_view(value == nullptr ? "" : value);
  };
  return ::isatty(stream) == 1 && given("NO_COLOR").empty() && !given("TERM").empty() &&
         given("TERM") != "dumb";
}

}  // namespace

void say_error(std::string_view message) {
  say("palpate: " + coloured("error:", Colour::red, STDERR_FILENO) + " %v", message);
}

void say_warning(std::string_view message) {
  say("palpate: " + coloured("warning:", Colour::yellow, STDERR_FILENO) + " %v", message);
}

void print_note(std::string_view message) {
  say("palpate: %v", message);
}

void say_progress(std::string_view message) {
  say("%H:%M:%S %v", message);
}

std::string coloured(std::string_view text, Colour colour, int stream) {
  std::string result(text);
  if (!shows_colours(stream)) return result;
  return (colour == Colour::red ? "\x1b[1;31m" : "\x1b[1;33m") + result + "\x1b[0m";
}

void print_out(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw Error("stdout", "writing", "'" + std::system_category().message(errno) + "'",
                "enough space for the whole output");
  }
}

}  // namespace palpate::app
