#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include <palpate/error.hpp>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

// No damage may make a reader crash, hang, throw anything but Error, or return a part of a mesh as the whole.
namespace palpate::io::testing {
namespace {

enum class Outcome { refused, whole, other_mesh };

/// Reads a damaged file. Fails the test unless it gives an Error or a mesh.
Outcome read_damaged(const std::filesystem::path& path) {
  try {
    return same_mesh(read_mesh(path).mesh, sample_mesh()) ? Outcome::whole : Outcome::other_mesh;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(path.stem().string()), std::string::npos) << "names no file: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line: " << message;
    return Outcome::refused;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception than Error: " << error.what();
    return Outcome::refused;
  }
}

TEST(DamagedMesh, CutAtAnyByteIsRefusedOrStillWhole) {
  const Folder folder;
  for (const Sample& sample : all_samples()) {
    std::size_t refused = 0;
    for (std::size_t length = 0; length < sample.bytes.size(); ++length) {
      const auto outcome =
          read_damaged(folder.write("cut" + sample.extension, sample.bytes.substr(0, length)));
      EXPECT_NE(outcome, Outcome::other_mesh) << sample.name << " cut to " << length << " bytes";
      if (outcome == Outcome::refused) ++refused;
    }
    EXPECT_GT(refused, sample.bytes.size() / 3) << sample.name;
  }
}

TEST(DamagedMesh, TetgenFilesCutAtAnyByteAreRefusedOrStillWhole) {
  const Folder folder;
  const std::string node = tetgen_node;
  const std::string ele = tetgen_ele;
  const auto path = folder.write("cut.node", node);
  for (std::size_t length = 0; length < ele.size(); ++length) {
    ASSERT_FALSE(folder.write("cut.ele", ele.substr(0, length)).empty());
    EXPECT_NE(read_damaged(path), Outcome::other_mesh) << ".ele cut to " << length << " bytes";
  }
  ASSERT_FALSE(folder.write("cut.ele", ele).empty());
  for (std::size_t length = 0; length < node.size(); ++length) {
    ASSERT_FALSE(folder.write("cut.node", node.substr(0, length)).empty());
    EXPECT_EQ(read_damaged(path), Outcome::refused) << ".node cut to " << length << " bytes";
  }
}

/// One to three random changes: a bit, a byte, a byte that means something to a parser, or a number made
/// longer.
std::string damaged(std::string bytes, std::mt19937_64& random) {
  constexpr std::string_view meaningful = "0123456789<>/\"=$#-+.eE \n";
  for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 5) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(random() % 256);
        break;
      case 2:
        bytes[at] = meaningful[random() % meaningful.size()];
        break;
      case 3:
        bytes.insert(at, std::string(1 + random() % 12, '9'));
        break;
      default:
        bytes.erase(at, 1 + random() % 8);
        if (bytes.empty()) bytes.push_back(' ');
    }
  }
  return bytes;
}

TEST(DamagedMesh, AChangedByteInCompressedDataIsRefusedInSilence) {
  const Folder folder;
  std::size_t tried = 0;
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  for (const Sample& sample : vtu_by_vtk()) {
    const auto raw = sample.bytes.find("encoding=\"raw\"");
    const auto zlib = sample.bytes.find("vtkZLib");
    if (raw == std::string::npos || zlib == std::string::npos) continue;
    // zlib has a checksum: any change of the points' first block, behind '_' and the header, is found.
    const std::size_t word = sample.bytes.find("header_type=\"UInt64\"") != std::string::npos ? 8 : 4;
    const std::string_view mark = "<DataArray type=\"Float64\" Name=\"Points\"";
    const auto offset_at = sample.bytes.find("offset=\"", sample.bytes.find(mark)) + 8;
    const std::size_t offset = std::stoul(sample.bytes.substr(offset_at));
    const std::size_t block = sample.bytes.find('_', raw) + 1 + offset + (3 + 2) * word;
    std::string bytes = sample.bytes;
    bytes[block + 3] = static_cast<char>(bytes[block + 3] ^ 0x20);
    const auto message = error_of(folder.write("a.vtu", bytes));
    EXPECT_TRUE(message.starts_with("a.vtu: array Points: found a damaged compressed block, expected "))
        << sample.name << ": " << message;
    ++tried;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(tried, 4U);
}

TEST(DamagedMesh, RandomDamageNeverCrashesAReader) {
  const char* wanted = std::getenv("PALPATE_TEST_SEED");  // to repeat a failure
  const std::uint64_t seed = wanted != nullptr ? std::stoull(wanted) : std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  RecordProperty("seed", std::to_string(seed));
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::fflush(stdout);  // print the seed before a crash
  std::mt19937_64 random(seed);
  const Folder folder;
  std::size_t refused = 0;
  for (const Sample& sample : all_samples()) {
    SCOPED_TRACE(sample.name);
    for (int i = 0; i < 100; ++i) {
      if (read_damaged(folder.write("bad" + sample.extension, damaged(sample.bytes, random))) ==
          Outcome::refused)
        ++refused;
    }
  }
  EXPECT_GT(refused, 1000U);
  for (int i = 0; i < 500; ++i) {
    const auto path = folder.write("bad.node", damaged(tetgen_node, random));
    ASSERT_FALSE(folder.write("bad.ele", damaged(tetgen_ele, random)).empty());
    read_damaged(path);
  }
}

}  // namespace
}  // namespace palpate::io::testing
