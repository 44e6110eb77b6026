#include "io/atomic_file.hpp"

#include <sys/stat.h>

#include <palpate/error.hpp>

#include "results/support.hpp"
#include "support/file_size_limit.hpp"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using io::AtomicFile;
using io::write_atomically;
using Names = std::vector<std::string>;

/// The message of the Error that `action` throws.
template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no Error was thrown";
  return {};
}

TEST(AtomicFile, WritesAllBytesAndLeavesNothingElse) {
  const TemporaryFolder folder;
  std::string bytes(300'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7 % 251);
  write_atomically(folder / "new", bytes);
  EXPECT_EQ(content_of(folder / "new"), bytes);
  EXPECT_EQ(names_in(folder.path()), Names{"new"});
}

TEST(AtomicFile, ReplacesOnlyOnCommit) {
  const TemporaryFolder folder;
  put(folder / "file", "old");
  AtomicFile file(folder / "file");
  file.write("ne");
  file.write("w");
  EXPECT_EQ(content_of(folder / "file"), "old");
  file.commit();
  EXPECT_EQ(content_of(folder / "file"), "new");
  EXPECT_EQ(names_in(folder.path()), Names{"file"});
}

TEST(AtomicFile, AbandonedLeavesOldContentAndNoTemporary) {
  const TemporaryFolder folder;
  put(folder / "file", "old");
  { AtomicFile(folder / "file").write("new"); }
  EXPECT_EQ(content_of(folder / "file"), "old");
  EXPECT_EQ(names_in(folder.path()), Names{"file"});
}

TEST(AtomicFile, FullDiskIsAnErrorThatNamesThePath) {
  const TemporaryFolder folder;
  put(folder / "file", "old");
  std::string message;
  {
    const FileSizeLimit limit(4096);
    message = error_of([&] { write_atomically(folder / "file", std::string(100'000, 'x')); });
  }
  EXPECT_NE(message.find((folder / "file").string() + ": writing: found 'File too large'"), std::string::npos)
      << message;
  EXPECT_EQ(content_of(folder / "file"), "old");
  EXPECT_EQ(names_in(folder.path()), Names{"file"});
}

TEST(AtomicFile, MissingFolderIsAnErrorThatNamesThePath) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "none" / "file";
  const std::string message = error_of([&] { write_atomically(path, "x"); });
  EXPECT_EQ(message,
            path.string() +
                ": creating: found 'No such file or directory', expected a folder that exists and can "
                "be written to");
}

TEST(AtomicFile, FileInPlaceOfTheFolderIsAnError) {
  const TemporaryFolder folder;
  put(folder / "plain", "old");
  const fs::path path = folder.path() / "plain" / "file";
  EXPECT_NE(error_of([&] { write_atomically(path, "x"); }).find("Not a directory"), std::string::npos);
  EXPECT_NE(error_of([&] { io::create_folder(path); }).find(path.string()), std::string::npos);
  EXPECT_NE(error_of([&] { io::create_folder(folder / "plain"); }).find("Not a directory"),
            std::string::npos);
  EXPECT_EQ(content_of(folder / "plain"), "old");
}

TEST(AtomicFile, FolderRemovedMeanwhileIsAnError) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "gone");
  AtomicFile file(folder.path() / "gone" / "file");
  file.write("x");
  fs::remove_all(folder / "gone");
  EXPECT_NE(error_of([&] { file.commit(); }).find("renaming into place"), std::string::npos);
  EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(AtomicFile, NeverReplacesAFolderOrASpecialFile) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "folder");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_NE(error_of([&] { write_atomically(folder / "folder", "x"); }).find("found a folder"),
            std::string::npos);
  EXPECT_NE(error_of([&] { write_atomically(folder / "pipe", "x"); }).find("found a device"),
            std::string::npos);
  EXPECT_TRUE(fs::is_directory(folder / "folder"));
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(AtomicFile, ReplacesTheTargetOfALinkAndKeepsTheLink) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "deep");
  put(folder.path() / "deep" / "target", "old");
  fs::create_symlink("deep/target", folder / "link");
  write_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(content_of(folder.path() / "deep" / "target"), "new");
}

TEST(AtomicFile, HasThePermissionsOfAnyNewFile) {
  const TemporaryFolder folder;
  const mode_t old_mask = ::umask(027);
  write_atomically(folder / "file", "x");
  ::umask(old_mask);
  EXPECT_EQ(fs::status(folder / "file").permissions(), static_cast<fs::perms>(0640));
}

TEST(CreateFolder, CreatesParentsAndAcceptsWhatIsThere) {
  const TemporaryFolder folder;
  io::create_folder(folder.path() / "a" / "b");
  io::create_folder(folder.path() / "a" / "b");
  EXPECT_TRUE(fs::is_directory(folder.path() / "a" / "b"));
}

}  // namespace
}  // namespace palpate::test
