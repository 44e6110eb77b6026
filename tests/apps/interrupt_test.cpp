#include "interrupt.hpp"

#include <chrono>
#include <csignal>
#include <thread>
#include <unistd.h>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Interrupt : public CommandTest {
 protected:
  void SetUp() override { write("scene.json", falling_box()); }

  void wait_for_rows(std::size_t rows) const {
    wait_until([&] { return exists("out/metrics.csv") && lines_of(read("out/metrics.csv")).size() > rows; });
  }
  /// Expects that rows are whole and of consecutive steps; returns the last step. A SIGKILL may cut the
  /// current write, so then the text behind the last line end is ignored.
  std::size_t check_rows(bool killed = false) const {
    std::string text = read("out/metrics.csv");
    if (killed) text.resize(text.rfind('\n') + 1);
    EXPECT_TRUE(text.ends_with('\n'));
    const auto lines = lines_of(text);
    for (std::size_t row = 1; row < lines.size(); ++row) {
      EXPECT_EQ(fields_of(lines[row]).size(), fields_of(lines[0]).size()) << lines[row];
      EXPECT_EQ(fields_of(lines[row])[0], std::to_string(row - 1));
    }
    return lines.size() - 2;
  }

  const std::vector<std::string> endless_{"run",       "scene.json", "--steps", "100000000", "--every",
                                          "100000000", "--threads",  "1",       "--out",     "out"};
};

TEST_F(Interrupt, ABenchmarkKeepsTheItemsThatAreDone) {
  for (const char* name : {"stacking", "eye", "skull"}) write(std::string(name) + ".json", falling_box());
  for (const int signal : {SIGINT, SIGTERM}) {
    Process bench({"bench", "paper", "--scenes", ".", "--out", "out"}, folder_.path());
    wait_until([&] { return exists("out/report.json"); });
    bench.send(signal);
    const Finished done = bench.wait();
    EXPECT_EQ(done.exit_code, 1);
    const Json report = Json::parse(read("out/report.json"));
    EXPECT_EQ(report["complete"], false);
    EXPECT_GE(report["sections"].size(), 1U);
    EXPECT_LT(report["sections"].size(), 8U);
    const std::string line = "palpate: error: interrupted; out/report.json has " +
                             std::to_string(report["sections"].size()) + " of 8 items";
    EXPECT_EQ(lines_of(done.err).back(), line);
    EXPECT_EQ(done.out, "");
    std::filesystem::remove_all(folder_ / "out");
  }
}

TEST_F(Interrupt, KeepsWholeResultsAndExitsWithOne) {
  ::signal(SIGHUP, SIG_DFL);  // else it is inherited if the tests run under nohup
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Process run(endless_, folder_.path());
    wait_for_rows(2);
    run.send(signal);
    if (signal == SIGHUP) run.send(signal);  // as the system and the shell do
    const Finished done = run.wait();
    EXPECT_EQ(done.exit_code, 1);
    EXPECT_NE(done.err.find("palpate: error: interrupted after step "), std::string::npos) << done.err;
    const Json report = Json::parse(read("out/run.json"));
    EXPECT_EQ(report["interrupted"], true);
    EXPECT_EQ(report["steps"], check_rows());
    EXPECT_EQ(report["results"]["frames"], 2) << "the first and the last state";
    EXPECT_TRUE(report["results"]["picture"].is_null());
    EXPECT_EQ(names_in(folder_ / "out/frames").size(), 2U) << "no half-written file is left";
    EXPECT_EQ(names_in(folder_ / "out").size(), 6U)
        << "frames, their list, two files of rows, report, checkpoints";
    EXPECT_NE(done.out.find("interrupted"), std::string::npos) << done.out;
    std::filesystem::remove_all(folder_ / "out");
  }
}

TEST_F(Interrupt, IsNotLostWhileAModelIsRelaxed) {
  // Nothing overlaps, so that relaxing is one detection; the signal comes anywhere in it or around it.
  write("relaxed.json", falling_box(R"(, "relax": {})"));
  for (const int delay : {0, 1, 2, 4, 8, 16, 32, 64}) {
    Process run({"run", "relaxed.json", "--steps", "100000000", "--threads", "1", "--out", "out", "--quiet"},
                folder_.path());
    wait_until([&] { return run.handles(SIGINT); });
    std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    run.send(SIGINT);
    const Finished done = run.wait();
    EXPECT_EQ(done.exit_code, 1) << delay << " ms: " << done.err;
    EXPECT_NE(done.err.find("palpate: error: interrupted "), std::string::npos)
        << delay << " ms: " << done.err;
    std::filesystem::remove_all(folder_ / "out");
  }
}

TEST_F(Interrupt, WhilePicturesAreDrawnNoPageIsNamed) {
  Process run({"run", "scene.json", "--steps", "1", "--threads", "1", "--out", "out", "--report", "--set",
               "output.picture.size=[4000, 4000]"},
              folder_.path());
  wait_until([&] { return exists("out/run.json"); });
  run.send(SIGKILL);
  run.wait();
  const Json results = Json::parse(read("out/run.json"))["results"];
  EXPECT_EQ(results["report"].is_null(), !exists("out/report.html"));
  EXPECT_EQ(results["picture"].is_null(), !exists("out/picture.png"));
}

TEST_F(Interrupt, TheStateIsThatOfARunOfAsManySteps) {
  Process run(endless_, folder_.path());
  wait_for_rows(2);
  run.send(SIGINT);
  run.wait();
  const Json report = Json::parse(read("out/run.json"));
  const Json whole = json_of({"run", "scene.json", "--steps", std::to_string(report["steps"].get<int>()),
                              "--json", "--no-picture", "--threads", "1"});
  EXPECT_EQ(whole["state_hash"], report["state_hash"]);
}

TEST(InterruptDeathTest, ALaterSignalKillsAtOnce) {
  const auto two_signals = [](int first, int second) {
    const app::InterruptFlag flag;
    static_cast<void>(::raise(first));
    if (!flag.requested()) ::_exit(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    static_cast<void>(::raise(second));
    ::_exit(0);
  };
  EXPECT_EXIT(two_signals(SIGINT, SIGTERM), testing::KilledBySignal(SIGTERM), "");
  EXPECT_EXIT(two_signals(SIGHUP, SIGINT), testing::KilledBySignal(SIGINT), "");
  EXPECT_EXIT(two_signals(SIGTERM, SIGHUP), testing::ExitedWithCode(0), "");
}

TEST_F(Interrupt, SignalsThatComeTogetherAreOneRequest) {  // as timeout(1) sends them
  Process run(endless_, folder_.path());
  wait_for_rows(2);
  // A stopped process gets all of them at once when it continues, however busy the machine is.
  for (const int signal : {SIGSTOP, SIGINT, SIGTERM, SIGCONT}) run.send(signal);
  const Finished finished = run.wait();
  EXPECT_EQ(finished.exit_code, 1) << finished.err;
  EXPECT_TRUE(exists("out/run.json"));
}

TEST_F(Interrupt, AnIgnoredHangUpStaysIgnored) {
  ::signal(SIGHUP, SIG_IGN);  // as nohup does
  Process run(endless_, folder_.path());
  ::signal(SIGHUP, SIG_DFL);
  wait_for_rows(2);
  run.send(SIGHUP);
  wait_for_rows(lines_of(read("out/metrics.csv")).size() + 10);
  EXPECT_TRUE(run.running());
}

TEST_F(Interrupt, KilledRunsKeepWholeRows) {
  Process run(endless_, folder_.path());
  wait_for_rows(2);
  run.send(SIGKILL);
  EXPECT_EQ(run.wait().signal, SIGKILL);
  EXPECT_GE(check_rows(true), 1U);
  EXPECT_FALSE(exists("out/run.json"));
}

}  // namespace
}  // namespace palpate::test
