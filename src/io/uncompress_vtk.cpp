#include <vtkDataCompressor.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkSmartPointer.h>
#include <vtkZLibDataCompressor.h>

#include "io/uncompress.hpp"
#include "io/vtk_silence.hpp"

namespace palpate::io {
namespace {

vtkSmartPointer<vtkDataCompressor> make_compressor(VtuStructure::Compressor kind) {
  switch (kind) {
    case VtuStructure::Compressor::lz4:
      return vtkSmartPointer<vtkLZ4DataCompressor>::New();
    case VtuStructure::Compressor::lzma:
      return vtkSmartPointer<vtkLZMADataCompressor>::New();
    default:
      return vtkSmartPointer<vtkZLibDataCompressor>::New();
  }
}

}  // namespace

bool can_uncompress(VtuStructure::Compressor) {
  return true;
}

bool uncompress(VtuStructure::Compressor compressor, std::string_view block, std::span<char> target) {
  const VtkSilence silence;
  const auto* bytes = reinterpret_cast<const unsigned char*>(block.data());
  return make_compressor(compressor)
             ->Uncompress(bytes, block.size(), reinterpret_cast<unsigned char*>(target.data()),
                          target.size()) == target.size();
}

}  // namespace palpate::io
