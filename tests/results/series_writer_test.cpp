#include "io/series_writer.hpp"

#include <cstdlib>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUtilities.h>

#include <palpate/error.hpp>

#include "results/support.hpp"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

struct Entry {
  double time = 0.0;
  std::string file;
};

/// The entries of a .pvd, by VTK's XML parser.
std::vector<Entry> entries_of(const fs::path& collection) {
  vtkSmartPointer<vtkXMLDataElement> root;
  root.TakeReference(vtkXMLUtilities::ReadElementFromFile(collection.c_str()));
  std::vector<Entry> entries;
  if (root == nullptr) {
    ADD_FAILURE() << "no XML: " << content_of(collection);
    return entries;
  }
  EXPECT_STREQ(root->GetName(), "VTKFile");
  EXPECT_STREQ(root->GetAttribute("type"), "Collection");
  vtkXMLDataElement* list = root->FindNestedElementWithName("Collection");
  for (int i = 0; list != nullptr && i < list->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* element = list->GetNestedElement(i);
    EXPECT_STREQ(element->GetName(), "DataSet");
    entries.push_back(
        {std::strtod(element->GetAttribute("timestep"), nullptr), element->GetAttribute("file")});
  }
  return entries;
}

class SeriesWriterTest : public ::testing::Test {
 protected:
  void add(io::SeriesWriter& series, double time) {
    series.add(
        time, {.points = mesh_.points, .tets = mesh_.tets, .point_arrays = {}, .tet_arrays = {}, .time = {}});
  }
  TemporaryFolder folder_;
  TetMesh mesh_ = box_mesh({0, 0, 0}, {1, 1, 1}, 1);
};

TEST_F(SeriesWriterTest, OpensAndIsCompleteAfterEachFrame) {
  const fs::path out = folder_.path() / "deep" / "out";
  io::SeriesWriter series(out, "run");
  EXPECT_EQ(series.collection_path(), out / "run.pvd");
  EXPECT_TRUE(entries_of(out / "run.pvd").empty());
  const std::vector<double> times{0.0, 0.1 + 0.2, 1e-7, 123456.789};
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    add(series, times[frame]);
    const auto entries = entries_of(out / "run.pvd");
    ASSERT_EQ(entries.size(), frame + 1);
    for (std::size_t i = 0; i <= frame; ++i) {
      EXPECT_EQ(entries[i].time, times[i]);
      EXPECT_EQ(entries[i].file, "frames/frame_00000" + std::to_string(i) + ".vtu");
      vtkNew<vtkXMLUnstructuredGridReader> reader;
      reader->SetFileName((out / entries[i].file).c_str());
      reader->Update();
      EXPECT_EQ(reader->GetOutput()->GetNumberOfCells(), 6);
    }
  }
  EXPECT_EQ(series.frame_count(), times.size());
  EXPECT_EQ(names_in(out).size(), 2U);
}

TEST_F(SeriesWriterTest, FramesOfAnEarlierRunGoAndNothingElse) {
  const fs::path frames = folder_ / "frames";
  {
    io::SeriesWriter series(folder_.path(), "run");
    add(series, 0.0);
    add(series, 1.0);
  }
  const std::vector<std::string> foreign{"frame_1.vtu", "frame_00000x.vtu", "my_frame_000000.vtu",
                                         "frame_000000.vtk"};
  for (const std::string& name : foreign) put(frames / name, "mine");
  const io::SeriesWriter series(folder_.path(), "run");
  EXPECT_TRUE(entries_of(folder_ / "run.pvd").empty());
  EXPECT_EQ(names_in(frames).size(), foreign.size());
  for (const std::string& name : foreign) EXPECT_EQ(content_of(frames / name), "mine");
}

TEST_F(SeriesWriterTest, FailedFrameIsNotListed) {
  io::SeriesWriter series(folder_.path(), "run");
  add(series, 0.0);
  fs::create_directory(series.frame_path(1));
  EXPECT_THROW(add(series, 1.0), Error);
  EXPECT_EQ(entries_of(folder_ / "run.pvd").size(), 1U);
  fs::remove(series.frame_path(1));
  add(series, 2.0);
  const auto entries = entries_of(folder_ / "run.pvd");
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[1].time, 2.0);
}

TEST_F(SeriesWriterTest, FileInPlaceOfTheFolderIsAnError) {
  put(folder_ / "file", "x");
  EXPECT_THROW(io::SeriesWriter(folder_ / "file", "run"), Error);
}

TEST_F(SeriesWriterTest, SameFramesSameBytes) {
  for (const char* name : {"a", "b"}) {
    io::SeriesWriter series(folder_ / name, "run");
    Bodies bodies;
    bodies.add("box", box_mesh({0, 0, 0}, {1, 1, 1}, 2));
    const std::vector<Vec3> velocities(27, Vec3{1, 2, 3});
    const std::vector<std::uint8_t> in_contact(27, 1);
    const std::vector<double> depths(27, 0.5);
    series.add(bodies, {.time = 0.5,
                        .positions = bodies.points_rest(),
                        .velocities = velocities,
                        .in_contact = in_contact,
                        .depths = depths});
  }
  EXPECT_EQ(entries_of(folder_.path() / "a" / "run.pvd").size(), 1U);
  EXPECT_EQ(content_of(folder_.path() / "a" / "run.pvd"), content_of(folder_.path() / "b" / "run.pvd"));
  EXPECT_EQ(content_of(folder_.path() / "a/frames/frame_000000.vtu"),
            content_of(folder_.path() / "b/frames/frame_000000.vtu"));
}

}  // namespace
}  // namespace palpate::test
