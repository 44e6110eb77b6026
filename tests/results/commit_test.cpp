// The build script that looks up the commit, run on checkouts made for the test.
#include <chrono>
#include <cstdlib>
#include <sys/wait.h>

#include "results/support.hpp"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

void run(const std::string& command) {
  const int status = std::system((command + " > /dev/null 2>&1").c_str());
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command;
}

/// A path as one word of the shell; scratch folders and checkouts may have spaces.
std::string word(const fs::path& path) {
  std::string quoted(1, '\'');
  quoted += path.string();
  return quoted += '\'';
}

/// Runs the script and returns the quoted text in its output.
std::string commit_of(const fs::path& source, const fs::path& output) {
  run(word(PALPATE_CMAKE) + " -DSOURCE_DIR=" + word(source) + " -DOUTPUT=" + word(output) + " -P " +
      word(PALPATE_SOURCE_DIR "/src/io/machine_commit.cmake"));
  const std::string text = content_of(output);
  const std::size_t begin = text.find('"') + 1;
  return text.substr(begin, text.rfind('"') - begin);
}

void make_checkout(const fs::path& folder) {
  fs::create_directories(folder / "inner");
  put(folder / "tracked", "one");
  const std::string git = "git -C " + word(folder) + " -c user.name=t -c user.email=t@t ";
  run(git + "init");
  run(git + "add tracked");
  run(git + "commit -m first");
}

std::string head_of(const fs::path& checkout, const fs::path& scratch) {
  run("(git -C " + word(checkout) + " rev-parse HEAD > " + word(scratch) + ")");
  std::string head = content_of(scratch);
  head.resize(head.find_last_not_of('\n') + 1);
  return head;
}

TEST(Commit, CleanAndDirtyCheckout) {
  const TemporaryFolder folder;
  const fs::path checkout = folder / "checkout";
  make_checkout(checkout);
  const std::string head = head_of(checkout, folder / "head");
  ASSERT_EQ(head.size(), 40U);
  EXPECT_EQ(commit_of(checkout, folder / "out.cpp"), head);
  put(checkout / "untracked", "does not count");
  EXPECT_EQ(commit_of(checkout, folder / "out.cpp"), head);
  put(checkout / "tracked", "two");
  EXPECT_EQ(commit_of(checkout, folder / "out.cpp"), head + "-dirty");
}

TEST(Commit, UnknownOutsideAndDeepInsideACheckout) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "plain");
  EXPECT_EQ(commit_of(folder / "plain", folder / "out.cpp"), "unknown");
  make_checkout(folder / "checkout");
  EXPECT_EQ(commit_of(folder.path() / "checkout" / "inner", folder / "out.cpp"), "unknown");
}

TEST(Commit, SameTextLeavesTheFileAlone) {
  const TemporaryFolder folder;
  commit_of(folder.path(), folder / "out.cpp");
  const auto old_time = fs::last_write_time(folder / "out.cpp") - std::chrono::hours(1);
  fs::last_write_time(folder / "out.cpp", old_time);
  commit_of(folder.path(), folder / "out.cpp");
  EXPECT_EQ(fs::last_write_time(folder / "out.cpp"), old_time);
}

}  // namespace
}  // namespace palpate::test
