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
#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "io/vtk_silence.hpp"
#include "organ.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

/// Converts to VTK, without unused points.
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

/// Spacing of the lattice: 1/150 of the diagonal; for thin sheets a third of their thickness, unless that
/// needs too many points.
double lattice_spacing(vtkPolyData* surface, double thickness) {
  constexpr double steps_along_diagonal = 150.0;
  constexpr double steps_through = 3.0;
  constexpr double most_points = 4e6;
  const double* bounds = surface->GetBounds();
  const double coarse = surface->GetLength() / steps_along_diagonal;
  const double thin = thickness / steps_through;
  double points = 1.0;
  for (std::size_t a = 0; a < 3; ++a) points *= (bounds[2 * a + 1] - bounds[2 * a]) / coarse + 5.0;
  const double finest = coarse * std::cbrt(points / most_points);
  return std::min(coarse, std::max(thin, finest));
}

/// A lattice round the surface with a margin of two cells.
Lattice lattice_round(vtkPolyData* surface, double spacing) {
  constexpr int margin = 2;
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

double distance_to(const std::array<Vec3, 2>& line, const Vec3& p) {
  const Vec3 along = line[1] - line[0];
  const double square = dot(along, along);
  const double fraction = square > 0.0 ? std::clamp(dot(p - line[0], along) / square, 0.0, 1.0) : 0.0;
  return length(p - line[0] - fraction * along);
}

/// Adds a cylinder along a segment where parts touch, so that they are joined. Otherwise the surface would be
/// no manifold there, and a mesher would refine for ever.
void add_bar(const std::array<Vec3, 2>& line, Lattice& field) {
  constexpr double cells = 1.5;
  const double radius = cells * field.spacing.x;
  Box box;
  box.extend(line[0]);
  box.extend(line[1]);
  std::array<int, 3> first{};
  std::array<int, 3> count{};
  const std::array<double Vec3::*, 3> axes{&Vec3::x, &Vec3::y, &Vec3::z};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto step = [&](double x) { return (x - field.origin.*axes[a]) / field.spacing.x; };
    first[a] = std::max(0, static_cast<int>(std::floor(step(box.lower.*axes[a]) - cells)));
    const int last = static_cast<int>(std::ceil(step(box.upper.*axes[a]) + cells));
    count[a] = std::min(last, field.size[a] - 1) - first[a] + 1;
  }
  for_points(count, [&](int i, int j, int k) {
    const std::array<int, 3> here{first[0] + i, first[1] + j, first[2] + k};
    float& value = field.values[field.index(here[0], here[1], here[2])];
    const double away = distance_to(line, field.place(here[0], here[1], here[2]));
    value = std::max(value, static_cast<float>(radius - away));
  });
}

/// Volume and area of the surface; if the triangles do not all face the same side, the volume belongs to
/// the box.
std::array<double, 2> volume_and_area(vtkPolyData* surface, bool one_sided) {
  vtkNew<vtkMassProperties> mass;
  mass->SetInputData(surface);
  const double* b = surface->GetBounds();
  const double box = (b[1] - b[0]) * (b[3] - b[2]) * (b[5] - b[4]);
  return {one_sided ? mass->GetVolume() : box, mass->GetSurfaceArea()};
}

}  // namespace

SurfaceShape surface_field(const fs::path& path, const Shaping& shaping) {
  PolygonFile file = read_surface_file(path);
  const io::VtkSilence silence;
  ClosedSurface closed = closed_surface(surface_of(std::move(file)), shaping, path.string());
  const auto surface = poly_data_of(closed.surface);
  const auto [volume, area] = volume_and_area(surface, closed.one_sided);
  const double thickness = 2.0 * volume / area;
  Lattice signs = lattice_round(surface, lattice_spacing(surface, thickness));
  set_signs(surface, signs, static_cast<float>(2.0 * signs.spacing.x));
  SurfaceShape shape{signs, volume, closed.one_sided ? thickness : 0.0, std::move(closed.remarks)};
  set_distances(surface, signs, shape.field);
  if (!closed.one_sided) shape.volume = positive_volume(shape.field);
  for (const auto& joint : closed.joints) add_bar(joint, shape.field);
  for (float& value : shape.field.values) value -= static_cast<float>(0.5 * shaping.gap);
  return shape;
}

}  // namespace palpate::app
