#include <algorithm>
#include <limits>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkMassProperties.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include "io/vtk_silence.hpp"
#include "lattice.hpp"

namespace palpate::app {

double mean_thickness(const Lattice& lattice) {
  const io::VtkSilence silence;
  vtkNew<vtkImageData> image;
  image->SetDimensions(lattice.size.data());
  image->SetSpacing(lattice.spacing.x, lattice.spacing.y, lattice.spacing.z);
  image->AllocateScalars(VTK_FLOAT, 1);
  std::ranges::copy(lattice.values, static_cast<float*>(image->GetScalarPointer()));
  vtkNew<vtkFlyingEdges3D> surface;
  surface->SetInputData(image);
  surface->SetValue(0, 0.0);
  surface->ComputeNormalsOff();
  surface->Update();
  if (surface->GetOutput()->GetNumberOfCells() == 0) return std::numeric_limits<double>::infinity();
  vtkNew<vtkMassProperties> mass;
  mass->SetInputConnection(surface->GetOutputPort());
  return 2.0 * positive_volume(lattice) / mass->GetSurfaceArea();
}

}  // namespace palpate::app
