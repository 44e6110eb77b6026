#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkImageStencilData.h>
#include <vtkImplicitPolyDataDistance.h>
#include <vtkMassProperties.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataToImageStencil.h>

#include "closed_surface.hpp"
#include "geometry/vector.hpp"
#include "io/vtk_silence.hpp"
#include "organ.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

/// For VTK, with the points that are used alone.
vtkSmartPointer<vtkPolyData> poly_data_of(const Surface& surface) {
  std::vector<vtkIdType> number(surface.points.size(), -1);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> triangles;
  for (const Triangle& triangle : surface.triangles) {
    std::array<vtkIdType, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      vtkIdType& id = number[static_cast<std::size_t>(triangle[i])];
      const Vec3& p = at(surface.points, triangle[i]);
      if (id < 0) id = points->InsertNextPoint(p.x, p.y, p.z);
      corners[i] = id;
    }
    triangles->InsertNextCell(3, corners.data());
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(triangles);
  return data;
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

void set_distances(vtkPolyData* surface, const Lattice& signs, Lattice& field) {
  vtkNew<vtkImplicitPolyDataDistance> distance;
  distance->SetInput(surface);
  for_points(signs.size, [&](int i, int j, int k) {
    if (!is_near_surface(signs, i, j, k)) return;
    float& value = field.values[signs.index(i, j, k)];
    const Vec3 p = signs.place(i, j, k);
    const double away = std::abs(distance->EvaluateFunction(p.x, p.y, p.z));
    value = static_cast<float>(value > 0.0F ? away : -away);
  });
}

/// Where triangles face one side, by Gauss's theorem; else that of the field.
double volume_of(vtkPolyData* surface, bool one_sided, const Lattice& field) {
  if (!one_sided) return positive_volume(field);
  vtkNew<vtkMassProperties> mass;
  mass->SetInputData(surface);
  return mass->GetVolume();
}

}  // namespace

SurfaceShape surface_field(const fs::path& path, const Shaping& shaping) {
  const PolygonFile file = read_surface_file(path);
  const io::VtkSilence silence;
  ClosedSurface closed = closed_surface(surface_of(file), shaping, path.string());
  const auto surface = poly_data_of(closed.surface);
  Lattice signs = lattice_round(surface);
  set_signs(surface, signs, static_cast<float>(2.0 * signs.spacing.x));
  SurfaceShape shape{signs, 0.0, std::move(closed.remarks)};
  set_distances(surface, signs, shape.field);
  shape.volume = volume_of(surface, closed.one_sided, shape.field);
  for (float& value : shape.field.values) value -= static_cast<float>(0.5 * shaping.gap);
  return shape;
}

}  // namespace palpate::app
