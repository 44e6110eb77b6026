// 'palpate view' as a user meets it.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "apps/workplace.hpp"
#include "view/client.hpp"
#include "view/page.hpp"

namespace palpate::test {
namespace {

class View : public CommandTest {
 protected:
  void SetUp() override {
    if (view::page_files().empty()) GTEST_SKIP() << "this build has no page: npm was missing";
    write("scene.json", falling_box());
  }
};

/// The first line that a process writes to a file; empty where it ended, or after a minute.
std::string first_line(const std::filesystem::path& file, Process& process) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (process.running() && std::chrono::steady_clock::now() < deadline) {
    const std::string text = content_of(file);
    if (text.find('\n') != std::string::npos) return text.substr(0, text.find('\n'));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return "";
}

TEST_F(View, PrintsTheAddressServesAndEndsWithCtrlC) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::filesystem::path out = folder_ / "address";
    std::filesystem::remove(out);
    Process process({"view", "scene.json", "--json", "--no-browser"}, folder_.path(), out);
    const Json line = Json::parse(first_line(out, process));
    const std::string address = line["address"];
    const auto port = line["port"].get<std::uint16_t>();
    const std::string start = "http://127.0.0.1:" + std::to_string(port);
    ASSERT_TRUE(address.starts_with(start + "/")) << address;
    EXPECT_EQ(get(port, address.substr(start.size())).status, 200);
    EXPECT_EQ(get(port, "/").status, 401);
    process.send(signal);
    const Finished done = process.wait();
    EXPECT_EQ(done.exit_code, 0);
    EXPECT_EQ(done.err, "");
  }
}

class DoorToTheView : public View {};

TEST_F(DoorToTheView, AMeshIsShownAtOnce) {
  output_of({"generate", "ball", "--radius", "40", "--resolution", "3"});
  const std::filesystem::path out = folder_ / "address";
  Process process({"view", "ball.vtu", "--json", "--no-browser"}, folder_.path(), out);
  const Json line = Json::parse(first_line(out, process));
  EXPECT_EQ(get(line["port"].get<std::uint16_t>(), "/").status, 401) << "it serves";
  process.send(SIGINT);
  const Finished done = process.wait();
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_EQ(
      done.err,
      "palpate: ball.vtu in mm: 0.08 m, 0.25 kg; its lowest tenth is held, and an instrument presses it; "
      "'palpate new ball.vtu' writes this scene\n");
  EXPECT_FALSE(exists("ball.json"));
}

TEST_F(View, WarnsWhenOtherMachinesCanReachIt) {
  const std::filesystem::path out = folder_ / "address";
  Process process({"view", "scene.json", "--host", "0.0.0.0", "--no-browser"}, folder_.path(), out);
  EXPECT_TRUE(first_line(out, process).starts_with("http://0.0.0.0:"));
  process.send(SIGINT);
  EXPECT_NE(process.wait().err.find("every machine that reaches this one"), std::string::npos);
}

TEST_F(View, RefusesInOneLine) {
  expect_error(2, {"view"}, {"SCENE"});
  expect_error(2, {"view", "nothing.json"}, {"nothing.json"});
  expect_error(2, {"view", "mesh.vtu"}, {"mesh.vtu", "no such file"});
  expect_error(2, {"view", "."}, {"run.json"});
  expect_error(2, {"view", "scene.json", "--port", "70000"}, {"--port", "70000"});
  expect_error(2, {"view", "scene.json", "--speed", "0"}, {"--speed"});
  expect_error(2, {"view", "scene.json", "--host", "nowhere", "--no-browser"}, {"--host", "nowhere"});
  ::setenv("PALPATE_VIEW_TOKEN", "too short", 1);
  expect_error(2, {"view", "scene.json"}, {"PALPATE_VIEW_TOKEN"});
  ::unsetenv("PALPATE_VIEW_TOKEN");
}

}  // namespace
}  // namespace palpate::test
