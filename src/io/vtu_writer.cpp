#include "io/vtu_writer.hpp"

#include <string_view>
#include <vector>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/atomic_file.hpp"

namespace palpate::io {
namespace {

/// A VTK array over our memory. VTK needs a pointer to non-const, but a writer only reads.
template <class VtkArray, class Value>
vtkSmartPointer<VtkArray> borrow(const Value* values, std::size_t rows, int components) {
  auto array = vtkSmartPointer<VtkArray>::New();
  array->SetNumberOfComponents(components);
  constexpr int keep_ours = 1;
  array->SetArray(const_cast<Value*>(values), static_cast<vtkIdType>(rows) * components, keep_ours);
  return array;
}

vtkSmartPointer<vtkDataArray> to_vtk(std::span<const double> values, int components = 1) {
  return borrow<vtkDoubleArray>(values.data(), values.size() / static_cast<std::size_t>(components),
                                components);
}
vtkSmartPointer<vtkDataArray> to_vtk(std::span<const Vec3> values, int = 1) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return borrow<vtkDoubleArray>(reinterpret_cast<const double*>(values.data()), values.size(), 3);
}
vtkSmartPointer<vtkDataArray> to_vtk(std::span<const Index> values, int = 1) {
  return borrow<vtkTypeInt32Array>(values.data(), values.size(), 1);
}
vtkSmartPointer<vtkDataArray> to_vtk(std::span<const std::uint8_t> values, int = 1) {
  return borrow<vtkUnsignedCharArray>(values.data(), values.size(), 1);
}

void add_arrays(const std::string& source, std::span<const NamedArray> arrays, std::size_t rows,
                std::string_view kind, vtkFieldData* fields) {
  for (const NamedArray& array : arrays) {
    const std::size_t length = std::visit([](const auto& values) { return values.size(); }, array.values);
    const std::size_t expected = rows * static_cast<std::size_t>(array.components);
    if (length != expected) {
      throw Error(source, std::string(kind) + " array '" + array.name + "'",
                  std::to_string(length) + " values", std::to_string(expected));
    }
    // VTK writes names into an XML attribute without escaping them.
    if (array.name.empty() || array.name.find_first_of("<&\"") != std::string::npos) {
      throw Error(source, std::string(kind) + " array", "the name '" + array.name + "'",
                  "one of at least a letter, without <, & and \"");
    }
    const auto data =
        std::visit([&](const auto& values) { return to_vtk(values, array.components); }, array.values);
    data->SetName(array.name.c_str());
    if (!array.unit.empty()) data->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), array.unit.c_str());
    fields->AddArray(data);
  }
}

void check_indices(const std::string& source, const VtuData& data) {
  for (std::size_t tet = 0; tet < data.tets.size(); ++tet) {
    for (const Index corner : data.tets[tet]) {
      if (corner >= 0 && static_cast<std::size_t>(corner) < data.points.size()) continue;
      throw Error(source, "tet " + std::to_string(tet), "point " + std::to_string(corner),
                  "an index below " + std::to_string(data.points.size()));
    }
  }
}

vtkSmartPointer<vtkCellArray> cells_of(std::span<const Tet> tets) {
  vtkNew<vtkTypeInt32Array> offsets;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(tets.size()) + 1);
  for (vtkIdType i = 0; i < offsets->GetNumberOfValues(); ++i)
    offsets->SetValue(i, static_cast<Index>(4 * i));
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  const Index* corners = tets.empty() ? nullptr : tets.front().data();
  cells->SetData(offsets, borrow<vtkTypeInt32Array>(corners, 4 * tets.size(), 1));
  return cells;
}

vtkSmartPointer<vtkUnstructuredGrid> grid_of(const std::string& source, const VtuData& data) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetData(to_vtk(data.points));
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells_of(data.tets));
  add_arrays(source, data.point_arrays, data.points.size(), "point", grid->GetPointData());
  add_arrays(source, data.tet_arrays, data.tets.size(), "tet", grid->GetCellData());
  if (data.time) {
    vtkNew<vtkDoubleArray> time;
    time->SetName("TimeValue");
    time->InsertNextValue(*data.time);
    grid->GetFieldData()->AddArray(time);
  }
  return grid;
}

}  // namespace

void write_vtu(const std::filesystem::path& path, const VtuData& data) {
  const std::string source = path.string();
  check_indices(source, data);
  AtomicFile file(path);  // opened first, so that a bad path is an error at once
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(grid_of(source, data));
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetByteOrderToLittleEndian();
  writer->SetHeaderTypeToUInt64();
  writer->SetCompressorTypeToZLib();
  writer->SetCompressionLevel(
      1);  // higher levels hardly compress floating-point noise, at several times the work
  writer->WriteToOutputStringOn();
  if (writer->Write() != 1) throw Error(source, "", "a failure of VTK's writer", "a mesh that VTK can write");
  file.write(writer->GetOutputString());
  file.commit();
}

namespace {

/// Positions for a frame. Points in no tet never move; they get the position of a point of their body that is
/// in a tet, so that bounds are the bounds of the bodies.
std::vector<Vec3> positions_of_tets(const Bodies& bodies, std::span<const Vec3> positions) {
  std::vector<Vec3> result(positions.begin(), positions.end());
  for (std::size_t b = 0; b < bodies.bodies().size(); ++b) {
    if (bodies.notes()[b].unreferenced_points == 0) continue;
    const Body& body = bodies.bodies()[b];
    const Vec3& home = at(positions, at(bodies.tets(), body.tets.begin)[0]);
    for (Index p = body.points.begin; p < body.points.end; ++p) {
      if (bodies.point_tets()[p].empty()) at(result, p) = home;
    }
  }
  return result;
}

}  // namespace

void write_frame(const std::filesystem::path& path, const Bodies& bodies, const FrameState& state) {
  const std::span<const Vec3> rest = bodies.points_rest();
  if (state.positions.size() != rest.size()) {
    throw Error(path.string(), "positions", std::to_string(state.positions.size()),
                std::to_string(rest.size()));
  }
  std::vector<Vec3> displacements(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) displacements[i] = state.positions[i] - rest[i];
  const std::vector<Vec3> positions = positions_of_tets(bodies, state.positions);
  std::vector<Index> body_of_tet;
  body_of_tet.reserve(bodies.tets().size());
  for (const Tet& tet : bodies.tets()) body_of_tet.push_back(bodies.body_of(tet));

  std::vector<NamedArray> point_arrays{
      {"displacement", std::span<const Vec3>(displacements), 1, state.length_unit},
      {"velocity", state.velocities, 1, state.speed_unit},
      {"body", bodies.body_of_point()},
      {"contact", state.in_contact},
      {"depth", state.depths, 1, state.length_unit}};
  std::vector<NamedArray> tet_arrays{{"body", std::span<const Index>(body_of_tet)}};
  point_arrays.insert(point_arrays.end(), state.point_fields.begin(), state.point_fields.end());
  tet_arrays.insert(tet_arrays.end(), state.tet_fields.begin(), state.tet_fields.end());
  write_vtu(path, {.points = positions,
                   .tets = bodies.tets(),
                   .point_arrays = point_arrays,
                   .tet_arrays = tet_arrays,
                   .time = state.time});
}

}  // namespace palpate::io
