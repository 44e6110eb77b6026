// What `palpate bench peers` refuses. contest_test.cpp tests its comparison.
#include <gtest/gtest.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class BenchPeers : public CommandTest {};

TEST_F(BenchPeers, APythonThatCannotBeRunIsRefused) {
  write("text", "no program");
  for (const char* python : {"no/such/python", "text", "."}) {
    expect_error(2, {"bench", "peers", "--quick", "--python", python, "--out", "out"},
                 {"--python: found '" + std::string(python) + "'", "can be run"});
  }
  EXPECT_FALSE(exists("out"));
}

}  // namespace
}  // namespace palpate::test
