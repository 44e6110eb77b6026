#include <algorithm>
#include <gtest/gtest.h>
#include <locale>
#include <unistd.h>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

namespace palpate::io::testing {
namespace {

TEST(MeshReader, ReadsTheSameMeshFromEveryFormat) {
  const Folder folder;
  const auto samples = all_samples();
  ASSERT_GE(samples.size(), 40U);
  for (const Sample& sample : samples) {
    SCOPED_TRACE(sample.name);
    ASSERT_NO_THROW(
        expect_sample(read_mesh(folder.write("sample" + sample.extension, sample.bytes)), sample.format));
  }
}

TEST(MeshReader, ReadsFilesWithWindowsLineEnds) {
  const Folder folder;
  for (const Sample& sample :
       {Sample{"", ".msh", "Gmsh 2.2 ASCII", gmsh_2}, Sample{"", ".mesh", "Medit ASCII", medit},
        Sample{"", ".vtk", "VTK legacy ASCII", vtk_5}, Sample{"", ".vtu", "VTK XML", vtu_ascii}}) {
    std::string text;
    for (const char c : sample.bytes) text += c == '\n' ? "\r\n" : std::string(1, c);
    SCOPED_TRACE(sample.extension);
    ASSERT_NO_THROW(expect_sample(read_mesh(folder.write("sample" + sample.extension, text)), sample.format));
  }
}

struct CommaPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\1"; }
};

TEST(MeshReader, ReadsAndSpeaksTheSameInEveryLocale) {
  const Folder folder;
  const auto samples = all_samples();
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaPoint));
  for (const Sample& sample : samples) {
    SCOPED_TRACE(sample.name);
    EXPECT_NO_THROW(
        expect_sample(read_mesh(folder.write("sample" + sample.extension, sample.bytes)), sample.format));
  }
  const auto message = error_of(folder.write("a.mesh", replaced(medit, "2 3 4 5 1", "2 3 4 1234567 1")));
  std::locale::global(before);
  EXPECT_EQ(message, "a.mesh: line 21: found point number 1234567, expected one from 1 to 5");
}

TEST(MeshReader, TakesTheExtensionInUpperCase) {
  const Folder folder;
  expect_sample(read_mesh(folder.write("SAMPLE.MSH", gmsh_2)), "Gmsh 2.2 ASCII");
}

TEST(MeshReader, ListsItsExtensions) {
  for (const char* extension : {".vtu", ".vtk", ".msh", ".node", ".ele", ".mesh"}) {
    const auto known = mesh_extensions();
    EXPECT_NE(std::find(known.begin(), known.end(), extension), known.end()) << extension;
  }
}

TEST(MeshReader, RefusesUnknownExtensions) {
  EXPECT_EQ(
      error_of("/a/liver.meshb"),
      "liver.meshb: found the extension .meshb, expected one of .vtu .vtk .msh .node .ele .mesh (did you "
      "mean .mesh?)");
  EXPECT_EQ(error_of("/a/liver.blender"),
            "liver.blender: found the extension .blender, expected one of .vtu .vtk .msh .node .ele .mesh");
  EXPECT_EQ(error_of("/a/liver"),
            "liver: found no file extension, expected one of .vtu .vtk .msh .node .ele .mesh");
}

class EveryExtension : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Formats, EveryExtension,
                         ::testing::Values(".vtu", ".vtk", ".msh", ".node", ".ele", ".mesh"),
                         [](const auto& parameter) { return std::string(parameter.param + 1); });

/// For TetGen, whose message may name the other file of the two.
std::string without_name(const std::string& message) {
  return message.substr(std::min(message.find(": found"), message.size()));
}

TEST_P(EveryExtension, RefusesAMissingFile) {
  const Folder folder;
  const auto message = without_name(error_of(folder.path() / (std::string("missing") + GetParam())));
  EXPECT_TRUE(message.starts_with(": found no such file, expected ")) << message;
}

TEST_P(EveryExtension, RefusesAFolder) {
  const Folder folder;
  const auto path = folder.path() / (std::string("folder") + GetParam());
  std::filesystem::create_directory(path);
  std::filesystem::create_directory(folder.path() / "folder.node");
  const auto message = without_name(error_of(path));
  EXPECT_TRUE(message.starts_with(": found a folder, expected ")) << message;
}

TEST_P(EveryExtension, RefusesAnEmptyFile) {
  const Folder folder;
  const auto other = folder.write("empty.node", "");
  const auto message = without_name(error_of(folder.write(std::string("empty") + GetParam(), "")));
  EXPECT_TRUE(message.starts_with(": found an empty file, expected ")) << message;
}

TEST_P(EveryExtension, CallsALfsPointerOne) {
  const Folder folder;
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n";
  const auto other = folder.write("far.node", pointer);
  const auto message = without_name(error_of(folder.write(std::string("far") + GetParam(), pointer)));
  EXPECT_TRUE(message.starts_with(": found a git-LFS pointer instead of the file itself")) << message;
  EXPECT_NE(message.find("'git lfs pull'"), std::string::npos) << message;
}

TEST_P(EveryExtension, RefusesAFileThatMayNotBeRead) {
  const Folder folder;
  const auto path = folder.write(std::string("secret") + GetParam(), "x");
  const auto other = folder.write("secret.node", "x");
  for (const auto& file : {path, other}) std::filesystem::permissions(file, std::filesystem::perms::none);
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  constexpr uid_t nobody = 65534;
  const bool is_root = geteuid() == 0;  // root may read everything, so it asks as somebody else
  if (is_root) {
    ASSERT_EQ(seteuid(nobody), 0);
  }
  const auto message = without_name(error_of(path));
  if (is_root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  EXPECT_TRUE(message.starts_with(": found a file that cannot be opened (Permission denied), expected "))
      << message;
}

TEST_P(EveryExtension, RefusesADevice) {
  const Folder folder;
  const auto path = folder.path() / (std::string("endless") + GetParam());
  std::filesystem::create_symlink("/dev/zero", path);
  if (path.extension() == ".ele")
    std::filesystem::create_symlink("/dev/zero", folder.path() / "endless.node");
  const auto message = without_name(error_of(path));
  EXPECT_TRUE(message.starts_with(": found something that is not a regular file, expected ")) << message;
}

}  // namespace
}  // namespace palpate::io::testing
