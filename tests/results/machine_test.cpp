#include "io/machine.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sstream>

namespace palpate::io {
namespace {

std::string model_in(const std::string& text) {
  std::istringstream stream(text);
  return cpu_model(stream);
}

TEST(Machine, CpuModelFromCpuinfo) {
  EXPECT_EQ(
      model_in("processor\t: 0\nmodel\t\t: 17\nmodel name\t: AMD EPYC 9755 128-Core \nmodel name\t: other\n"),
      "AMD EPYC 9755 128-Core");
  EXPECT_EQ(model_in("processor : 0\nBogoMIPS : 48\n"), "unknown");
  EXPECT_EQ(model_in("model name\t:\n"), "unknown");
  EXPECT_EQ(model_in(""), "unknown");
}

TEST(Machine, DescribesThisOne) {
  const Machine machine = describe_machine();
  EXPECT_FALSE(machine.cpu.empty());
  cpu_set_t usable;
  ASSERT_EQ(sched_getaffinity(0, sizeof usable, &usable), 0);
  EXPECT_EQ(machine.cores, CPU_COUNT(&usable));
#ifdef __clang__  // which also says that it is an old GNU
  const std::string version = std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__);
#else
  const std::string version = std::to_string(__GNUC__) + "." + std::to_string(__GNUC_MINOR__);
#endif
  EXPECT_NE(machine.compiler.find(version), std::string::npos) << machine.compiler;
  const std::string commit = machine.commit.substr(0, machine.commit.find('-'));
  EXPECT_TRUE(commit == "unknown" ||
              (commit.size() == 40 && commit.find_first_not_of("0123456789abcdef") == std::string::npos))
      << machine.commit;
#ifdef NDEBUG
  EXPECT_TRUE(machine.build_type.starts_with("Rel")) << machine.build_type;
#else  // the sanitizer presets keep assertions in an optimised build
  EXPECT_TRUE(machine.build_type.starts_with("Debug") || machine.build_type.starts_with("RelWithDebInfo"))
      << machine.build_type;
#endif
#ifdef __SANITIZE_ADDRESS__
  EXPECT_NE(machine.build_type.find("address"), std::string::npos) << machine.build_type;
#endif
}

}  // namespace
}  // namespace palpate::io
