// Lists of frames. Oracle: files written by hand, and files of SeriesWriter.
#include "io/series_reader.hpp"

#include <gtest/gtest.h>

#include <palpate/error.hpp>

#include "io/series_writer.hpp"
#include "results/support.hpp"

namespace palpate::test {
namespace {

std::string collection(const std::string& sets) {
  return R"(<?xml version="1.0"?><VTKFile type="Collection"><Collection>)" + sets + "</Collection></VTKFile>";
}

TEST(SeriesReader, ReadsTimesAndFiles) {
  const TemporaryFolder folder;
  put(folder / "a.pvd", collection(R"(<DataSet timestep="0" part="0" file="frames/x.vtu"/>
    <DataSet file="y.vtu" timestep="2.5e-1"></DataSet>)"));
  const auto frames = io::read_series(folder / "a.pvd");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].time, 0.0);
  EXPECT_EQ(frames[0].file, folder / "frames/x.vtu");
  EXPECT_EQ(frames[1].time, 0.25);
  EXPECT_EQ(frames[1].file, folder / "y.vtu");
}

TEST(SeriesReader, ReadsWhatTheWriterWrites) {
  const TemporaryFolder folder;
  Bodies bodies;
  bodies.add("box", box_mesh({0, 0, 0}, {1, 1, 1}, 1));
  io::SeriesWriter writer(folder.path(), "frames");
  const std::vector<Vec3> velocities(8);
  const std::vector<std::uint8_t> contact(8);
  const std::vector<double> depths(8);
  for (const double time : {0.0, 0.1}) {
    writer.add(bodies, {time, bodies.points_rest(), velocities, contact, depths});
  }
  const auto frames = io::read_series(writer.collection_path());
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].time, 0.1);
  EXPECT_TRUE(std::filesystem::exists(frames[1].file));
}

TEST(SeriesReader, RefusesOtherFilesAndPathsOutside) {
  const TemporaryFolder folder;
  for (const std::string& text : std::vector<std::string>{
           "", "hello", "<VTKFile></VTKFile>", collection(R"(<DataSet timestep="x" file="a.vtu"/>)"),
           collection(R"(<DataSet timestep="0"/>)"), collection(R"(<DataSet timestep="0" file="../a.vtu"/>)"),
           collection(R"(<DataSet timestep="0" file="b/../../a.vtu"/>)"),
           collection(R"(<DataSet timestep="0" file="/etc/passwd"/>)"),
           collection(R"(<DataSet timestep="1" file="a.vtu"/><DataSet timestep="1" file="b.vtu"/>)"),
           collection("<DataSet")}) {
    put(folder / "a.pvd", text);
    EXPECT_THROW(io::read_series(folder / "a.pvd"), Error) << text;
  }
  EXPECT_THROW(io::read_series(folder / "nothing.pvd"), Error);
}

}  // namespace
}  // namespace palpate::test
