#include <zlib.h>

#include "io/uncompress.hpp"

namespace palpate::io {

bool can_uncompress(VtuStructure::Compressor compressor) {
  return compressor == VtuStructure::Compressor::zlib;
}

bool uncompress(VtuStructure::Compressor compressor, std::string_view block, std::span<char> target) {
  if (!can_uncompress(compressor)) return false;
  uLongf length = target.size();
  const auto* bytes = reinterpret_cast<const Bytef*>(block.data());
  const int status = ::uncompress(reinterpret_cast<Bytef*>(target.data()), &length, bytes, block.size());
  return status == Z_OK && length == target.size();
}

}  // namespace palpate::io
