#include "command_line.hpp"

int main(int argc, char** argv) {
  return palpate::app::run_command_line(argc, argv);
}
