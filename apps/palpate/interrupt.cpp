#include "interrupt.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <unistd.h>

#include "exit_codes.hpp"

namespace palpate::app {
namespace {

constexpr std::array<int, 3> signals{SIGINT, SIGTERM, SIGHUP};

volatile std::sig_atomic_t interrupt_requested = 0;
std::atomic<std::int64_t> requested_at{0};  ///< ms
static_assert(decltype(requested_at)::is_always_lock_free);

std::int64_t milliseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1000} * now.tv_sec + now.tv_nsec / 1000000;
}

/// Does only what is allowed in a signal handler. One request may come as several signals: timeout(1) sends
/// two, and a lost terminal is reported by the system and by the shell.
extern "C" void request_interrupt(int signal) {
  constexpr std::int64_t at_once = 250;  // ms
  if (interrupt_requested == 0) {
    requested_at = milliseconds();
    interrupt_requested = 1;
  } else if (signal != SIGHUP && milliseconds() - requested_at > at_once) {
    ::signal(signal, SIG_DFL);
    static_cast<void>(::raise(signal));
  }
}

std::atomic<const char*> last_line{nullptr};
static_assert(decltype(last_line)::is_always_lock_free);

/// Does only what is allowed in a signal handler.
extern "C" void end_at_once(int /*signal*/) {
  const char* const line = last_line;
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line, std::strlen(line));
  ::_exit(exit_failed);
}

bool is_ignored(int signal) {
  struct sigaction now {};
  ::sigaction(signal, nullptr, &now);
  return now.sa_handler == SIG_IGN;
}

void handle(void (*handler)(int)) {
  for (const int signal : signals) {
    if (is_ignored(signal)) continue;
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace

InterruptFlag::InterruptFlag() {
  interrupt_requested = 0;
  handle(request_interrupt);
}

InterruptFlag::~InterruptFlag() {
  if (!requested()) handle(SIG_DFL);  // else signals of the same request may still come
}

bool InterruptFlag::requested() const {
  return interrupt_requested != 0;
}

InterruptEnd::InterruptEnd(const char* line) {
  last_line = line;
  handle(end_at_once);
}

InterruptEnd::~InterruptEnd() {
  handle(SIG_DFL);
}

}  // namespace palpate::app
