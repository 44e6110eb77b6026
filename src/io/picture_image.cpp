#include "io/picture_image.hpp"

#include <algorithm>
#include <string_view>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include "io/atomic_file.hpp"

namespace palpate::io {

void write_png(const std::filesystem::path& path, const Image& image) {
  AtomicFile file(path);
  vtkNew<vtkImageData> picture;
  picture->SetDimensions(image.width, image.height, 1);
  picture->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* out = static_cast<std::uint8_t*>(picture->GetScalarPointer());
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(image.width);
  for (int y = image.height - 1; y >= 0; --y) {  // VTK counts rows from the bottom
    out = std::copy_n(image.pixel(0, y), row_bytes, out);
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(picture);
  writer->WriteToMemoryOn();
  writer->Write();
  const vtkUnsignedCharArray* result = writer->GetResult();
  file.write({reinterpret_cast<const char*>(const_cast<vtkUnsignedCharArray*>(result)->GetPointer(0)),
              static_cast<std::size_t>(result->GetNumberOfValues())});
  file.commit();
}

}  // namespace palpate::io
