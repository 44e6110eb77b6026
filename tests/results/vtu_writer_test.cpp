#include "io/vtu_writer.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <palpate/error.hpp>

#include "results/support.hpp"

namespace palpate::test {
namespace {

using io::NamedArray;
using io::VtuData;

vtkSmartPointer<vtkUnstructuredGrid> read(const std::filesystem::path& path) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  return reader->GetOutput();
}

/// Expects the same bits: also for -0.0, NaN and denormal numbers.
void expect_bits(double found, double expected) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(found), std::bit_cast<std::uint64_t>(expected));
}

void expect_array(vtkDataSetAttributes* attributes, const char* name, int type,
                  const std::vector<double>& expected, int components = 1) {
  vtkDataArray* array = attributes->GetArray(name);
  ASSERT_NE(array, nullptr) << name;
  EXPECT_EQ(array->GetDataType(), type) << name;
  ASSERT_EQ(array->GetNumberOfComponents(), components) << name;
  ASSERT_EQ(array->GetNumberOfValues(), static_cast<vtkIdType>(expected.size())) << name;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto row = static_cast<vtkIdType>(i) / components;
    expect_bits(array->GetComponent(row, static_cast<int>(i) % components), expected[i]);
  }
}

std::vector<double> flat(std::span<const Vec3> values) {
  std::vector<double> numbers;
  for (const Vec3& v : values) numbers.insert(numbers.end(), {v.x, v.y, v.z});
  return numbers;
}

template <class Value>
std::vector<double> as_doubles(const std::vector<Value>& values) {
  return {values.begin(), values.end()};
}

/// Five points, two tets, and an array of each kind with awkward values.
struct Sample {
  std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1.0 / 3.0, 1e-310, 1e300}};
  std::vector<Tet> tets{{0, 1, 2, 3}, {4, 1, 2, 3}};
  std::vector<Vec3> vectors{{-0.0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}, {12, 13, 14}};
  std::vector<double> numbers{0.1, -2.5, 1e-300, std::nextafter(1.0, 2.0),
                              std::numeric_limits<double>::quiet_NaN()};
  std::vector<Index> labels{-1, 0, 2147483647, 3, 4};
  std::vector<std::uint8_t> flags{0, 1, 255, 1, 0};
  std::vector<Index> tet_labels{7, -8};
  std::vector<NamedArray> point_arrays{{"vectors", std::span<const Vec3>(vectors)},
                                       {"numbers", std::span<const double>(numbers)},
                                       {"labels", std::span<const Index>(labels)},
                                       {"flags", std::span<const std::uint8_t>(flags)}};
  std::vector<NamedArray> tet_arrays{{"tet labels", std::span<const Index>(tet_labels)}};
  [[nodiscard]] VtuData data() const {
    return {
        .points = points, .tets = tets, .point_arrays = point_arrays, .tet_arrays = tet_arrays, .time = 0.1};
  }
};

TEST(VtuWriter, VtkReadsBackEveryBit) {
  const TemporaryFolder folder;
  const Sample sample;
  io::write_vtu(folder / "sample.vtu", sample.data());
  const auto grid = read(folder / "sample.vtu");
  ASSERT_EQ(grid->GetNumberOfPoints(), 5);
  ASSERT_EQ(grid->GetNumberOfCells(), 2);
  const auto coordinates = flat(sample.points);
  for (vtkIdType i = 0; i < 5; ++i) {
    for (int c = 0; c < 3; ++c) {
      expect_bits(grid->GetPoint(i)[c], coordinates[static_cast<std::size_t>(3 * i + c)]);
    }
  }
  for (vtkIdType i = 0; i < 2; ++i) {
    EXPECT_EQ(grid->GetCellType(i), VTK_TETRA);
    vtkNew<vtkIdList> corners;
    grid->GetCellPoints(i, corners);
    ASSERT_EQ(corners->GetNumberOfIds(), 4);
    for (vtkIdType c = 0; c < 4; ++c) {
      EXPECT_EQ(corners->GetId(c), sample.tets[static_cast<std::size_t>(i)][static_cast<std::size_t>(c)]);
    }
  }
  EXPECT_EQ(grid->GetPointData()->GetNumberOfArrays(), 4);
  expect_array(grid->GetPointData(), "vectors", VTK_DOUBLE, flat(sample.vectors), 3);
  expect_array(grid->GetPointData(), "numbers", VTK_DOUBLE, sample.numbers);
  expect_array(grid->GetPointData(), "labels", VTK_INT, as_doubles(sample.labels));
  expect_array(grid->GetPointData(), "flags", VTK_UNSIGNED_CHAR, as_doubles(sample.flags));
  expect_array(grid->GetCellData(), "tet labels", VTK_INT, as_doubles(sample.tet_labels));
  vtkDataArray* time = grid->GetFieldData()->GetArray("TimeValue");
  ASSERT_NE(time, nullptr);
  expect_bits(time->GetComponent(0, 0), 0.1);
}

TEST(VtuWriter, SameDataSameBytes) {
  const TemporaryFolder folder;
  const Sample first;
  const Sample second;
  io::write_vtu(folder / "a.vtu", first.data());
  io::write_vtu(folder / "b.vtu", second.data());
  EXPECT_FALSE(content_of(folder / "a.vtu").empty());
  EXPECT_EQ(content_of(folder / "a.vtu"), content_of(folder / "b.vtu"));
  EXPECT_EQ(names_in(folder.path()).size(), 2U);
}

TEST(VtuWriter, MeshWithoutArrays) {
  const TemporaryFolder folder;
  const TetMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1}, 20);
  io::write_vtu(folder / "box.vtu",
                {.points = mesh.points, .tets = mesh.tets, .point_arrays = {}, .tet_arrays = {}, .time = {}});
  const auto grid = read(folder / "box.vtu");
  EXPECT_EQ(grid->GetNumberOfPoints(), 21 * 21 * 21);
  EXPECT_EQ(grid->GetNumberOfCells(), 6 * 20 * 20 * 20);
  EXPECT_EQ(grid->GetFieldData()->GetArray("TimeValue"), nullptr);
}

/// Expects an Error with this message (after the path) and the old content unchanged.
void expect_refused(const VtuData& data, const std::string& message) {
  const TemporaryFolder folder;
  put(folder / "old.vtu", "old");
  try {
    io::write_vtu(folder / "old.vtu", data);
    ADD_FAILURE() << "no Error";
  } catch (const Error& error) {
    EXPECT_EQ(error.what(), (folder / "old.vtu").string() + ": " + message);
  }
  EXPECT_EQ(content_of(folder / "old.vtu"), "old");
  EXPECT_EQ(names_in(folder.path()).size(), 1U);
}

TEST(VtuWriter, RefusesWhatDoesNotFit) {
  Sample sample;
  sample.tets[1][2] = 5;
  expect_refused(sample.data(), "tet 1: found point 5, expected an index below 5");
  sample.tets[1][2] = -1;
  expect_refused(sample.data(), "tet 1: found point -1, expected an index below 5");
  sample.tets[1][2] = 2;
  sample.point_arrays[1].values = std::span<const double>(sample.numbers).first(4);
  expect_refused(sample.data(), "point array 'numbers': found 4 values, expected 5");
  sample.point_arrays[1].values = std::span<const double>(sample.numbers);
  for (const char* name :
       {"", "a<b", "a&b", "a\"b"}) {  // VTK writes names as they are, and cannot read these back
    sample.point_arrays[1].name = name;
    expect_refused(sample.data(), "point array: found the name '" + std::string(name) +
                                      "', expected one of at least a letter, without <, & and \"");
  }
}

TEST(VtuWriter, UnwritablePathIsAnError) {
  const Sample sample;
  EXPECT_THROW(io::write_vtu("/nonexistent/folder/a.vtu", sample.data()), Error);
}

TEST(FrameWriter, ArraysOfAStep) {
  const TemporaryFolder folder;
  Bodies bodies;
  bodies.add("left", box_mesh({0, 0, 0}, {1, 1, 1}, 1));
  bodies.add("right", box_mesh({2, 0, 0}, {3, 1, 1}, 1));
  const std::size_t points = 16;
  std::vector<Vec3> positions, displacements, velocities;
  std::vector<std::uint8_t> in_contact;
  std::vector<double> depths, body_of_point;
  for (std::size_t i = 0; i < points; ++i) {
    const auto number = static_cast<double>(i);
    displacements.push_back({0.5 * number, -0.25, 4.0});  // exact in binary, so that differences are too
    const Vec3& rest = bodies.points_rest()[i];
    positions.push_back(
        {rest.x + displacements[i].x, rest.y + displacements[i].y, rest.z + displacements[i].z});
    velocities.push_back({0.1 * number, 0.2, 0.3});
    in_contact.push_back(i % 2);
    depths.push_back(0.01 * number);
    body_of_point.push_back(i < 8 ? 0.0 : 1.0);
  }
  io::write_frame(folder / "frame.vtu", bodies,
                  {.time = 0.75,
                   .positions = positions,
                   .velocities = velocities,
                   .in_contact = in_contact,
                   .depths = depths});
  const auto grid = read(folder / "frame.vtu");
  ASSERT_EQ(grid->GetNumberOfPoints(), 16);
  EXPECT_EQ(grid->GetPoint(15)[0], positions[15].x);
  expect_array(grid->GetPointData(), "displacement", VTK_DOUBLE, flat(displacements), 3);
  expect_array(grid->GetPointData(), "velocity", VTK_DOUBLE, flat(velocities), 3);
  expect_array(grid->GetPointData(), "body", VTK_INT, body_of_point);
  expect_array(grid->GetPointData(), "contact", VTK_UNSIGNED_CHAR, as_doubles(in_contact));
  expect_array(grid->GetPointData(), "depth", VTK_DOUBLE, depths);
  expect_array(grid->GetCellData(), "body", VTK_INT, {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1});
  EXPECT_EQ(grid->GetFieldData()->GetArray("TimeValue")->GetComponent(0, 0), 0.75);
  positions.pop_back();
  EXPECT_THROW(io::write_frame(folder / "frame.vtu", bodies,
                               {.time = 0,
                                .positions = positions,
                                .velocities = velocities,
                                .in_contact = in_contact,
                                .depths = depths}),
               Error);
}

}  // namespace
}  // namespace palpate::test
