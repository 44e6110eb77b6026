#include "interrupt.hpp"

#include <array>
#include <csignal>

namespace palpate::app {
namespace {

constexpr std::array<int, 3> signals{SIGINT, SIGTERM, SIGHUP};

volatile std::sig_atomic_t interrupt_requested = 0;

/// Does only what is allowed in a signal handler.
extern "C" void request_interrupt(int) {
  interrupt_requested = 1;
  for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
  ::signal(SIGHUP, SIG_IGN);  // a lost terminal is reported twice, by the system and by the shell
}

bool is_ignored(int signal) {
  struct sigaction now {};
  ::sigaction(signal, nullptr, &now);
  return now.sa_handler == SIG_IGN;
}

}  // namespace

InterruptFlag::InterruptFlag() {
  interrupt_requested = 0;
  for (const int signal : signals) {
    if (is_ignored(signal)) continue;
    struct sigaction action {};
    action.sa_handler = request_interrupt;
    action.sa_flags = SA_RESTART;
    ::sigaction(signal, &action, nullptr);
  }
}

InterruptFlag::~InterruptFlag() {
  for (const int signal : signals) {
    if (!is_ignored(signal)) ::signal(signal, SIG_DFL);
  }
}

bool InterruptFlag::requested() const {
  return interrupt_requested != 0;
}

}  // namespace palpate::app
