// 'palpate view' on the command line.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <memory>
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

/// The first line that a process writes to a file; empty if it ended, or after a minute.
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
  output_of({"generate", "ball", "--radius", "40", "--resolution", "3", "--out", "my ball.vtu"});
  const std::filesystem::path out = folder_ / "address";
  Process process({"view", "my ball.vtu", "--json", "--no-browser"}, folder_.path(), out);
  const Json line = Json::parse(first_line(out, process));
  EXPECT_EQ(get(line["port"].get<std::uint16_t>(), "/").status, 401) << "it serves";
  process.send(SIGINT);
  const Finished done = process.wait();
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_EQ(
      done.err,
      "palpate: unit guessed: mm (choose with --unit)\n"
      "palpate: my ball.vtu in mm: 0.08 m, 0.25 kg; its lowest tenth is held, and an instrument presses it; "
      "\"palpate new 'my ball.vtu'\" writes this scene\n");
  EXPECT_FALSE(exists("my ball.json"));
}

/// Terminal output of 'view' with a port in use: it ends after the messages about the mesh.
class ViewOfAMesh : public View {
 protected:
  void SetUp() override {
    View::SetUp();
    if (IsSkipped()) return;
    output_of(
        {"generate", "box", "--cells", "7", "4", "3", "--size", "210", "100", "60", "--out", "liver.vtu"});
    const std::filesystem::path out = folder_ / "address";
    holder_ = std::make_unique<Process>(
        std::vector<std::string>{"view", "scene.json", "--json", "--no-browser"}, folder_.path(), out);
    const Json line = Json::parse(first_line(out, *holder_));
    port_ = std::to_string(line["port"].get<int>());
  }
  [[nodiscard]] std::string shown(const std::vector<std::string>& flags,
                                  const std::string& typed = "") const {
    std::vector<std::string> all{"view", "liver.vtu", "--no-browser", "--port", port_};
    all.insert(all.end(), flags.begin(), flags.end());
    return palpate_on_terminal(all, folder_.path(), 200, typed);
  }
  std::unique_ptr<Process> holder_;
  std::string port_;
};

TEST_F(ViewOfAMesh, TakesUnitSizeAndDrop) {
  const auto said = [&](const std::vector<std::string>& flags, const std::string& part) {
    const std::string text = shown(flags);
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_EQ(text.find("Enter"), std::string::npos) << "it asks what it was told: " << text;
  };
  said({"--unit", "cm"}, "liver.vtu in cm: 2.1 m");
  said({"--unit", "cm"}, "'palpate new liver.vtu --unit cm' writes this scene");
  said({"--size", "0.105"}, "scaled by 0.0005: 0.1 m");
  said({"--yes", "--drop"}, "it falls onto a floor");
  said({"--yes", "--drop"}, "'palpate new liver.vtu --drop' writes this scene");
}

TEST_F(ViewOfAMesh, AsksForTheUnitOnATerminal) {
  const std::string agreed = shown({}, "\n");
  EXPECT_NE(agreed.find("liver.vtu is 210 long: in mm, this is 0.21 m and 1.3 kg. Enter"), std::string::npos)
      << agreed;
  EXPECT_NE(agreed.find("liver.vtu in mm: 0.21 m"), std::string::npos) << agreed;
  EXPECT_NE(shown({}, "0.3\n").find("'palpate new liver.vtu --size 0.3' writes this scene"),
            std::string::npos);
  const std::string again = shown({}, "elephant\ncm\n");
  EXPECT_NE(again.find("found 'elephant', expected y, m, cm, mm, um"), std::string::npos) << again;
  EXPECT_NE(again.find("in cm: 2.1 m"), std::string::npos) << again;
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
  write("README.md", "# Palpate\n");
  write("picture", "\x89PNG");
  const std::string kinds =
      "expected a scene (.json), a mesh of tets (.vtu .vtk .msh .node .ele .mesh) or the folder of a run";
  expect_error(2, {"view", "README.md"},
               {"README.md: found a file that is neither a mesh nor a scene, " + kinds});
  expect_error(2, {"view", "picture"},
               {"picture: found a file that is neither a mesh nor a scene, " + kinds});
  expect_error(2, {"view", "nothing"}, {"nothing: found no such file or folder, " + kinds});
  expect_error(2, {"view", "skin.stl"}, {"skin.stl: found a surface", "palpate mesh skin.stl"});
  for (const std::vector<std::string>& flag :
       std::vector<std::vector<std::string>>{{"--unit", "mm"}, {"--size", "1"}, {"--drop"}, {"--yes"}}) {
    for (const auto& [what, found] :
         {std::pair("scene.json", "a scene"), std::pair(".", "the folder of a run")}) {
      std::vector<std::string> call{"view", what};
      call.insert(call.end(), flag.begin(), flag.end());
      expect_error(2, call, {flag.front() + ": found " + found + ", expected a mesh of tets"});
    }
  }
  expect_error(2, {"view", "liver.vtu", "--unit", "mm", "--size", "1"}, {"--size", "--unit"});
  expect_error(2, {"view", "scene.json", "--port", "70000"}, {"--port", "70000"});
  expect_error(2, {"view", "scene.json", "--speed", "0"}, {"--speed"});
  expect_error(2, {"view", "scene.json", "--speed", "fast"}, {"--speed", "'max'"});
  expect_error(2, {"view", "scene.json", "--host", "nowhere", "--no-browser"}, {"--host", "nowhere"});
  ::setenv("PALPATE_VIEW_TOKEN", "too short", 1);
  expect_error(2, {"view", "scene.json"}, {"PALPATE_VIEW_TOKEN"});
  ::unsetenv("PALPATE_VIEW_TOKEN");
}

}  // namespace
}  // namespace palpate::test
