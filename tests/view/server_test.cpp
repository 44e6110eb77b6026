// The server over real connections: refusals, that only the newest frame is sent, and that no message of a
// page stops the simulation.
#include "view/server.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <string>
#include <thread>
#include <vector>

#include <palpate/error.hpp>

#include "view/client.hpp"
#include "view/fuzz.hpp"
#include "view/messages.hpp"
#include "view/page.hpp"
#include "view/scenes.hpp"

namespace palpate::view {
namespace {

const std::string token = "token-of-the-test";

class ServerTest : public ::testing::Test {
 protected:
  ServerTest() : thread_([this] { serve(); }) {}
  ~ServerTest() override {
    stop_ = true;
    thread_.join();
  }
  void serve() {
    while (!stop_) server_.run_for(std::chrono::milliseconds(20));
  }
  [[nodiscard]] std::uint16_t port() const { return server_.port(); }
  [[nodiscard]] static std::string path(const std::string& name) { return "/" + token + "/" + name; }
  [[nodiscard]] std::int64_t steps() {
    return nlohmann::json::parse(server_.player().status()).value("steps", std::int64_t{0});
  }

  Server server_{
      {.token = token, .names = {}}, test::small_source(), {.playing = true, .alone = false, .speed = {}}};
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

nlohmann::json header_of(const test::Socket::Received& received) {
  return received.binary ? test::read_message(received.data).header : nlohmann::json::parse(received.data);
}

std::string shown(std::int64_t frame) {
  return R"({"shown": {"frame": )" + std::to_string(frame) + "}}";
}

TEST_F(ServerTest, ServesThePageBehindTheTokenOnly) {
  if (page_files().empty()) GTEST_SKIP() << "this build has no page: npm was missing";
  const test::Answer page = test::get(port(), path(""));
  EXPECT_EQ(page.status, 200);
  EXPECT_NE(page.body.find("app.js"), std::string::npos);
  EXPECT_EQ(test::get(port(), path("app.js")).body, page_files()[1].content);
  EXPECT_EQ(test::get(port(), "/").status, 401);
  EXPECT_EQ(test::get(port(), "/app.js").status, 401);
  EXPECT_EQ(test::get(port(), "/wrong-token-wrong/app.js").status, 401);
  EXPECT_EQ(test::get(port(), path("") + "nothing.js").status, 404);
}

TEST_F(ServerTest, RefusesForeignHostsAndOrigins) {
  const std::string line = "GET " + path("status") + " HTTP/1.1\r\n";
  EXPECT_EQ(test::get(port(), path("status")).status, 200);
  EXPECT_EQ(test::ask_raw(port(), line + "Host: evil.example\r\n\r\n").status, 403);
  EXPECT_EQ(test::ask_raw(port(), line + "\r\n").status, 403) << "no Host";
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port()) + "\r\n";
  EXPECT_EQ(test::ask_raw(port(), line + host + "Host: evil.example\r\n\r\n").status, 403) << "two of them";
  EXPECT_EQ(test::get(port(), path("status"), "Origin: http://evil.example\r\n").status, 403);
  const std::string upgrade =
      "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
      "dGhlIHNhbXBsZSBub25jZQ==\r\n";
  EXPECT_EQ(test::get(port(), path("socket"), upgrade).status, 403) << "a socket without an Origin";
  EXPECT_EQ(test::get(port(), path("socket"), upgrade + "Origin: http://evil.example\r\n").status, 403);
  const std::string origin = "Origin: http://127.0.0.1:" + std::to_string(port()) + "\r\n";
  EXPECT_EQ(test::get(port(), "/socket", upgrade + origin).status, 401) << "a socket without the token";
}

TEST_F(ServerTest, HasNoPathToClimbOutOf) {
  for (const char* name :
       {"../etc/passwd", "..%2f..%2fetc/passwd", "%2e%2e/%2e%2e/etc/passwd", "/etc/passwd",
        "....//....//etc/passwd", "app.js/../../../etc/passwd", "..\\..\\etc\\passwd", "index.html%00"}) {
    EXPECT_EQ(test::get(port(), path(name)).status, 404) << name;
  }
}

TEST_F(ServerTest, RefusesWhatIsNoRequest) {
  EXPECT_EQ(test::ask_raw(port(), "hello\r\n\r\n").status, 400);
  EXPECT_EQ(
      test::ask_raw(port(), "GET / HTTP/1.1\r\nX: " + std::string(100000, 'x') + "\r\n\r\n").status % 400, 0)
      << "a header without end: refused or cut off";
  EXPECT_EQ(test::get(port(), path("status"), "Content-Length: 1000000\r\n").status, 400) << "a body";
  EXPECT_EQ(test::ask_raw(port(), "POST " + path("status") +
                                      " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) + "\r\n\r\n")
                .status,
            405);
}

TEST_F(ServerTest, RunsWhileAPageLooksAndSendsStageThenFrames) {
  const auto status = nlohmann::json::parse(test::get(port(), path("status")).body);
  EXPECT_EQ(status, nlohmann::json({{"steps", 0}, {"simulated", 0.0}, {"time", 0.0}, {"step_seconds", 0.0}}))
      << "nobody looks";
  test::Socket page(port(), path("socket"));
  EXPECT_EQ(header_of(page.receive().value())["kind"], "stage");
  std::int64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    const auto frame = header_of(page.receive_kind("frame"));
    EXPECT_GT(frame["frame"], last);
    last = frame["frame"];
    page.send(shown(last));
  }
  EXPECT_GT(steps(), 0);
}

TEST_F(ServerTest, NeverBuildsAQueueForASlowPage) {
  test::Socket slow(port(), path("socket"));
  test::Socket quick(port(), path("socket"));
  std::int64_t newest = 0;
  while (newest < 12) {  // the slow page draws nothing meanwhile
    newest = header_of(quick.receive_kind("frame"))["frame"];
    quick.send(shown(newest));
  }
  const std::int64_t first = header_of(slow.receive_kind("frame"))["frame"];
  const std::int64_t second = header_of(slow.receive_kind("frame"))["frame"];
  EXPECT_LE(second, 4) << "the two that were on their way";
  slow.send(shown(first - 1));
  slow.send(shown(second));
  const std::int64_t third = header_of(slow.receive_kind("frame"))["frame"];
  EXPECT_GE(third, newest) << "all between are gone";
}

TEST_F(ServerTest, AnswersWhatItRefuses) {
  test::Socket page(port(), path("socket"));
  page.send("nonsense");
  EXPECT_EQ(header_of(page.receive_kind("refusal"))["kind"], "refusal");
  page.send(R"({"pull": {"vertex": 0, "target": [0, 0, 0]}})");
  const std::string why = header_of(page.receive_kind("refusal"))["why"];
  EXPECT_NE(why.find("fixed"), std::string::npos) << why;
  page.send(R"({"play": {"on": false}})", true);
  EXPECT_NE(std::string(header_of(page.receive_kind("refusal"))["why"]).find("bytes"), std::string::npos);
}

TEST_F(ServerTest, ClosesOnMessagesThatAreTooLong) {
  test::Socket page(port(), path("socket"));
  page.send(std::string(longest_message + 1, ' '));
  while (page.receive()) {
  }
  EXPECT_EQ(page.close_code(), 1009) << "too big";
  test::Socket other(port(), path("socket"));
  EXPECT_TRUE(header_of(other.receive_kind("frame")).contains("frame")) << "others continue";
}

/// A page that answers each frame. After two unanswered frames the server sends no more.
class AnsweringPage {
 public:
  explicit AnsweringPage(std::uint16_t port, const std::string& path) : socket_(port, path) {}
  void send(const std::string& text) { socket_.send(text); }
  nlohmann::json next() {
    const std::optional<test::Socket::Received> received = socket_.receive();
    if (!received) throw std::runtime_error("the server closed the connection");
    nlohmann::json header = header_of(*received);
    if (header["kind"] == "frame") socket_.send(shown(header["frame"]));
    return header;
  }
  /// Whether a change of a setting was accepted; earlier commands may still fill the queue of the player.
  bool changes_friction(double friction) {
    send(R"({"change": {"contact": {"friction": )" + std::to_string(friction) + "}}}");
    while (true) {
      const nlohmann::json header = next();
      if (header["kind"] == "refusal") return false;
      if (header["kind"] == "state" && header["settings"]["contact"]["friction"] == friction) return true;
    }
  }
  /// Restarts the simulation, and waits for this number of steps.
  void runs(std::int64_t steps) {
    send(R"({"speed": {"speed": "max"}})");
    send(R"({"reset": {}})");
    send(R"({"play": {"on": true}})");
    for (std::int64_t step = 0; step < steps;) {
      const nlohmann::json header = next();
      if (header["kind"] == "frame") step = header["counts"]["step"];
    }
  }

 private:
  test::Socket socket_;
};

/// Sends damaged commands; then another page must be answered, and the simulation must continue.
void expect_no_stop_by_fuzz(std::uint16_t port, const std::string& path, int messages, std::uint64_t seed) {
  test::Fuzz fuzz(seed);
  auto page = std::make_unique<test::Socket>(port, path);
  for (int i = 0; i < messages; ++i) {
    std::string text = fuzz.message();
    // A text that is not UTF-8 ends the connection: so only now and then.
    const bool ends = i % 1000 == 999;
    for (char& c : text) c = static_cast<char>(c & 0x7f);
    if (ends) text.push_back(static_cast<char>(0xff));
    ASSERT_TRUE(page->send(text)) << "what is merely wrong does not end a connection";
    if (!ends) continue;
    while (page->receive()) {
    }
    EXPECT_EQ(page->close_code(), 1007) << "the server has read all that came before";
    page = std::make_unique<test::Socket>(port, path);
  }
  page->send("nonsense");
  EXPECT_EQ(header_of(page->receive_kind("refusal"))["kind"], "refusal");
  AnsweringPage other(port, path);
  while (!other.changes_friction(0.125)) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  other.runs(3);
}

TEST_F(ServerTest, AFuzzOfAHundredThousandMessagesDoesNotStopIt) {
  expect_no_stop_by_fuzz(port(), path("socket"), 100'000, 7);
}

/// For `--gtest_repeat`: a new server and new messages each time. The rare failure was in the answer after
/// the messages (a page that did not answer frames waited for ever), so repeats find more than messages.
TEST_F(ServerTest, DISABLED_AShortFuzzDoesNotStopIt) {
  static std::uint64_t seed = 0;
  expect_no_stop_by_fuzz(port(), path("socket"), 2000, seed++);
}

TEST_F(ServerTest, HasRoomForSixtyFourConnections) {
  std::vector<std::unique_ptr<test::Socket>> pages;
  const auto open = [&] { pages.push_back(std::make_unique<test::Socket>(port(), path("socket"))); };
  for (int i = 0; i < 64; ++i) open();
  EXPECT_EQ(test::get(port(), path("status")).status, 0) << "closed at once";
  for (const auto& page : pages) EXPECT_EQ(header_of(page->receive().value())["kind"], "stage");
  pages.pop_back();
  while (test::get(port(), path("status")).status != 200) {  // the server hears of it in its own time
  }
}

TEST_F(ServerTest, LetsGoOfWhatAPageHeldWhenItGoes) {
  test::Socket stays(port(), path("socket"));
  std::size_t pulls = 0;
  const auto next_pulls = [&] {
    const auto frame = header_of(stays.receive_kind("frame"));
    stays.send(shown(frame["frame"]));
    return frame["counts"]["pulls"].size();
  };
  {
    test::Socket goes(port(), path("socket"));
    goes.send(R"({"pull": {"vertex": 20, "target": [0, 0, 0.1]}})");
    while (pulls == 0) pulls = next_pulls();
  }
  while (pulls != 0) pulls = next_pulls();
  SUCCEED();
}

TEST(Server, SaysWhereItCannotListen) {
  const auto serve = [](const std::string& host, std::uint16_t port) {
    Server server({.host = host, .port = port, .token = token, .names = {}}, test::small_source(), {});
    return server.port();
  };
  EXPECT_THROW(serve("nowhere", 0), Error);
  EXPECT_THROW(serve("203.0.113.7", 0), Error) << "no address of this machine";
  Server first({.token = token, .names = {}}, test::small_source(), {});
  EXPECT_THROW(serve("127.0.0.1", first.port()), Error) << "in use";
}

}  // namespace
}  // namespace palpate::view
