#include "io/mesh_samples.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "io/mesh_files.hpp"

namespace palpate::io::testing {
namespace {

/// Appends numbers as bytes.
struct ByteWriter {
  bool swapped = false;
  std::string bytes;

  template <class Number>
  void put(Number value) {
    auto raw = std::bit_cast<std::array<char, sizeof(Number)>>(value);
    if (swapped) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
  }
  void ints(std::initializer_list<std::int32_t> values) {
    for (const auto value : values) put(value);
  }
  void sizes(std::initializer_list<std::uint64_t> values) {
    for (const auto value : values) put(value);
  }
  void doubles(std::initializer_list<double> values) {
    for (const auto value : values) put(value);
  }
  void text(std::string_view words) { bytes += words; }
};

void fill_sample(vtkUnstructuredGrid& grid) {
  const TetMesh mesh = sample_mesh();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : mesh.points) points->InsertNextPoint(p.x, p.y, p.z);
  grid.SetPoints(points);
  const vtkIdType first[] = {0, 1, 2, 3};
  const vtkIdType triangle[] = {0, 1, 2};
  const vtkIdType second[] = {1, 2, 3, 4};
  grid.InsertNextCell(VTK_TETRA, 4, first);
  grid.InsertNextCell(VTK_TRIANGLE, 3, triangle);
  grid.InsertNextCell(VTK_TETRA, 4, second);
  vtkNew<vtkDoubleArray> values;
  values->SetName("temperature");
  for (int i = 0; i < 5; ++i) values->InsertNextValue(i);
  grid.GetPointData()->AddArray(values);
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string gmsh_2_binary(bool swapped) {
  ByteWriter out{swapped, {}};
  out.text("$MeshFormat\n2.2 1 8\n");
  out.ints({1});
  out.text("\n$EndMeshFormat\n$Nodes\n5\n");
  const TetMesh mesh = sample_mesh();
  const std::int32_t numbers[] = {10, 3, 7, 42, 8};
  for (std::size_t i = 0; i < 5; ++i) {
    out.ints({numbers[i]});
    out.doubles({mesh.points[i].x, mesh.points[i].y, mesh.points[i].z});
  }
  out.text("\n$EndNodes\n$Elements\n3\n");
  out.ints({2, 1, 2, 1, 1, 1, 10, 3, 7});                        // one triangle with two tags
  out.ints({4, 2, 1, 2, 99, 10, 3, 7, 42, 3, 99, 3, 7, 42, 8});  // two tets with one tag each
  out.text("\n$EndElements\n");
  return out.bytes;
}

std::string gmsh_40_binary(bool swapped) {
  ByteWriter out{swapped, {}};
  out.text("$MeshFormat\n4 1 8\n");
  out.ints({1});
  out.text("\n$EndMeshFormat\n$Nodes\n");
  out.sizes({2, 5});
  out.ints({1, 2, 1});
  out.sizes({2});
  out.ints({10});
  out.doubles({0, 0, 0, 0.5, 0.5});
  out.ints({3});
  out.doubles({1, 0, 0, 0.25, 0.5});
  out.ints({1, 3, 0});
  out.sizes({3});
  out.ints({7});
  out.doubles({0, 1, 0});
  out.ints({42});
  out.doubles({0, 0, 1});
  out.ints({8});
  out.doubles({1.5, 0.1, -2.5e-4});
  out.text("\n$EndNodes\n$Elements\n");
  out.sizes({2, 3});
  out.ints({1, 2, 2});
  out.sizes({1});
  out.ints({1, 10, 3, 7});
  out.ints({1, 3, 4});
  out.sizes({2});
  out.ints({2, 10, 3, 7, 42, 3, 3, 7, 42, 8});
  out.text("\n$EndElements\n");
  return out.bytes;
}

std::string gmsh_41_binary(bool swapped) {
  ByteWriter out{swapped, {}};
  out.text("$MeshFormat\n4.1 1 8\n");
  out.ints({1});
  out.text("\n$EndMeshFormat\n$Entities\n");
  out.sizes({0, 0, 0, 0});
  out.text("\n$EndEntities\n$Nodes\n");
  out.sizes({2, 5, 3, 42});
  out.ints({2, 1, 1});
  out.sizes({2, 10, 3});
  out.doubles({0, 0, 0, 0.5, 0.5, 1, 0, 0, 0.25, 0.5});
  out.ints({3, 1, 0});
  out.sizes({3, 7, 42, 8});
  out.doubles({0, 1, 0, 0, 0, 1, 1.5, 0.1, -2.5e-4});
  out.text("\n$EndNodes\n$Elements\n");
  out.sizes({2, 3, 1, 3});
  out.ints({2, 1, 2});
  out.sizes({1, 1, 10, 3, 7});
  out.ints({3, 1, 4});
  out.sizes({2, 2, 10, 3, 7, 42, 3, 3, 7, 42, 8});
  out.text("\n$EndElements\n");
  return out.bytes;
}

std::vector<Sample> vtk_legacy_by_vtk() {
  const Folder folder;
  vtkNew<vtkUnstructuredGrid> grid;
  fill_sample(*grid);
  std::vector<Sample> samples;
  for (const bool binary : {false, true}) {
    for (const auto version :
         {vtkDataWriter::VTK_LEGACY_READER_VERSION_4_2, vtkDataWriter::VTK_LEGACY_READER_VERSION_5_1}) {
      const std::string path = folder.path() / "sample.vtk";
      vtkNew<vtkUnstructuredGridWriter> writer;
      writer->SetInputData(grid);
      writer->SetFileName(path.c_str());
      writer->SetFileVersion(version);
      writer->SetFileType(binary ? VTK_BINARY : VTK_ASCII);
      writer->Write();
      const std::string kind = binary ? "binary" : "ASCII";
      samples.push_back(
          {"VTK's " + kind + " " + std::to_string(version), ".vtk", "VTK legacy " + kind, bytes_of(path)});
    }
  }
  return samples;
}

std::vector<Sample> vtu_by_vtk() {
  const Folder folder;
  vtkNew<vtkUnstructuredGrid> grid;
  fill_sample(*grid);
  using Writer = vtkXMLWriter;
  std::vector<Sample> samples;
  for (const int mode : {Writer::Ascii, Writer::Binary, Writer::Appended}) {
    for (const int compressor : {Writer::NONE, Writer::ZLIB, Writer::LZ4, Writer::LZMA}) {
      for (const int header : {Writer::UInt32, Writer::UInt64}) {
        for (const int order : {Writer::LittleEndian, Writer::BigEndian}) {
          for (const bool base64 : {false, true}) {
            if (base64 && mode != Writer::Appended) continue;
            const std::string path = folder.path() / "sample.vtu";
            vtkNew<vtkXMLUnstructuredGridWriter> writer;
            writer->SetInputData(grid);
            writer->SetFileName(path.c_str());
            writer->SetDataMode(mode);
            writer->SetCompressorType(compressor);
            writer->SetHeaderType(header);
            writer->SetByteOrder(order);
            writer->SetEncodeAppendedData(base64);
            writer->SetBlockSize(64);  // several blocks even for so small a mesh
            writer->Write();
            const std::string name = "VTK's vtu: mode " + std::to_string(mode) + ", compressor " +
                                     std::to_string(compressor) + ", header " + std::to_string(header) +
                                     ", order " + std::to_string(order) + (base64 ? ", base64" : "");
            samples.push_back({name, ".vtu", "VTK XML", bytes_of(path)});
          }
        }
      }
    }
  }
  return samples;
}

std::vector<Sample> all_samples() {
  std::vector<Sample> samples{{"Gmsh 1", ".msh", "Gmsh 1", gmsh_1},
                              {"Gmsh 2.2", ".msh", "Gmsh 2.2 ASCII", gmsh_2},
                              {"Gmsh 4.0", ".msh", "Gmsh 4.0 ASCII", gmsh_40},
                              {"Gmsh 4.1", ".msh", "Gmsh 4.1 ASCII", gmsh_41},
                              {"XML in a .vtk", ".vtk", "VTK XML", vtu_ascii},
                              {"Medit", ".mesh", "Medit ASCII", medit},
                              {"VTK legacy 3", ".vtk", "VTK legacy ASCII", vtk_4},
                              {"VTK legacy 5.1", ".vtk", "VTK legacy ASCII", vtk_5},
                              {"vtu", ".vtu", "VTK XML", vtu_ascii}};
  for (const bool swapped : {false, true}) {
    const std::string order = swapped ? ", other byte order" : "";
    samples.push_back({"Gmsh 2.2 binary" + order, ".msh", "Gmsh 2.2 binary", gmsh_2_binary(swapped)});
    samples.push_back({"Gmsh 4.0 binary" + order, ".msh", "Gmsh 4 binary", gmsh_40_binary(swapped)});
    samples.push_back({"Gmsh 4.1 binary" + order, ".msh", "Gmsh 4.1 binary", gmsh_41_binary(swapped)});
  }
  for (auto& sample : vtk_legacy_by_vtk()) samples.push_back(std::move(sample));
  for (auto& sample : vtu_by_vtk()) samples.push_back(std::move(sample));
  return samples;
}

}  // namespace palpate::io::testing
