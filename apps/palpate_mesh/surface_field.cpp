#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCleanPolyData.h>
#include <vtkFeatureEdges.h>
#include <vtkImageData.h>
#include <vtkImageStencilData.h>
#include <vtkImplicitPolyDataDistance.h>
#include <vtkMassProperties.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataToImageStencil.h>
#include <vtkTriangleFilter.h>

#include <palpate/error.hpp>

#include "io/vtk_silence.hpp"
#include "organ.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

/// The polygons as triangles, equal points joined.
vtkSmartPointer<vtkPolyData> triangles_of(const PolygonFile& file) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : file.points) points->InsertNextPoint(p.x, p.y, p.z);
  vtkNew<vtkCellArray> polygons;
  for (const std::vector<Index>& polygon : file.polygons) {
    polygons->InsertNextCell(static_cast<int>(polygon.size()));
    for (const Index point : polygon) polygons->InsertCellPoint(point);
  }
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(polygons);
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(surface);
  vtkNew<vtkCleanPolyData> clean;
  clean->SetInputConnection(triangles->GetOutputPort());
  clean->Update();
  return clean->GetOutput();
}

vtkSmartPointer<vtkPolyData> closed_surface(const PolygonFile& file, const fs::path& path) {
  auto surface = triangles_of(file);
  // So that lengths, their squares and parts of them stay finite, and above zero.
  constexpr double least = 1e-100;
  constexpr double most = 1e100;
  const double length = surface->GetLength();
  if (surface->GetNumberOfPolys() > 0 && !(length >= least && length <= most)) {
    throw Error(path.string(), "", fmt::format("a diagonal of {} mm", length), "one from 1e-100 to 1e100");
  }
  if (surface->GetNumberOfPolys() == 0) throw Error(path.string(), "", "no triangles", "a closed surface");
  vtkNew<vtkFeatureEdges> open;
  open->SetInputData(surface);
  open->FeatureEdgesOff();
  open->ManifoldEdgesOff();
  open->Update();
  if (const auto edges = open->GetOutput()->GetNumberOfCells(); edges > 0) {
    throw Error(path.string(), "", fmt::format("{} edges that do not join two triangles", edges),
                "a closed surface");
  }
  return surface;
}

/// A lattice round the surface with a margin of two cells.
Lattice lattice_round(vtkPolyData* surface) {
  constexpr int margin = 2;
  constexpr double steps_along_diagonal = 150.0;
  const double spacing = surface->GetLength() / steps_along_diagonal;
  Lattice lattice;
  lattice.spacing = {spacing, spacing, spacing};
  const double* bounds = surface->GetBounds();
  lattice.origin = {bounds[0] - margin * spacing, bounds[2] - margin * spacing, bounds[4] - margin * spacing};
  std::size_t points = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    lattice.size[a] =
        static_cast<int>(std::ceil((bounds[2 * a + 1] - bounds[2 * a]) / spacing)) + 2 * margin + 1;
    points *= static_cast<std::size_t>(lattice.size[a]);
  }
  lattice.values.assign(points, 0.0F);
  return lattice;
}

/// Sets each point of the lattice to +far or -far.
void set_signs(vtkPolyData* surface, Lattice& lattice, float far) {
  vtkNew<vtkPolyDataToImageStencil> stencil;
  stencil->SetInputData(surface);
  stencil->SetOutputOrigin(lattice.origin.x, lattice.origin.y, lattice.origin.z);
  stencil->SetOutputSpacing(lattice.spacing.x, lattice.spacing.y, lattice.spacing.z);
  stencil->SetOutputWholeExtent(0, lattice.size[0] - 1, 0, lattice.size[1] - 1, 0, lattice.size[2] - 1);
  stencil->SetTolerance(0.0);
  stencil->Update();
  vtkImageStencilData* inside = stencil->GetOutput();
  for_points(lattice.size, [&](int i, int j, int k) {
    lattice.values[lattice.index(i, j, k)] = inside->IsInside(i, j, k) != 0 ? far : -far;
  });
}

bool is_near_surface(const Lattice& lattice, int i, int j, int k) {
  const bool inside = lattice.values[lattice.index(i, j, k)] > 0.0F;
  bool near = false;
  for_points({3, 3, 3}, [&](int x, int y, int z) {
    const auto next = [&](int at, int step, int size) { return std::clamp(at + step - 1, 0, size - 1); };
    const std::size_t other =
        lattice.index(next(i, x, lattice.size[0]), next(j, y, lattice.size[1]), next(k, z, lattice.size[2]));
    near = near || (lattice.values[other] > 0.0F) != inside;
  });
  return near;
}

}  // namespace

Lattice surface_field(const fs::path& path, const Shaping& shaping, double& volume) {
  const PolygonFile file = read_surface_file(path);
  const io::VtkSilence silence;
  const auto surface = closed_surface(file, path);
  vtkNew<vtkMassProperties> mass;
  mass->SetInputData(surface);
  volume = mass->GetVolume();

  Lattice signs = lattice_round(surface);
  set_signs(surface, signs, static_cast<float>(2.0 * signs.spacing.x));
  vtkNew<vtkImplicitPolyDataDistance> distance;
  distance->SetInput(surface);
  Lattice field = signs;
  for_points(signs.size, [&](int i, int j, int k) {
    float& value = field.values[signs.index(i, j, k)];
    if (is_near_surface(signs, i, j, k)) {
      const Vec3 p = signs.place(i, j, k);
      const double away = std::abs(distance->EvaluateFunction(p.x, p.y, p.z));
      value = static_cast<float>(value > 0.0F ? away : -away);
    }
    value -= static_cast<float>(0.5 * shaping.gap);
  });
  return field;
}

}  // namespace palpate::app
