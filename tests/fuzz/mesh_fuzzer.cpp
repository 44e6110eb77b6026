// A mesh file of one format, given by PALPATE_FUZZ_EXTENSION. For TetGen's two files, the text after a line
// of "----" is the .ele file.
#include <string>
#include <string_view>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>
#include <palpate/mesh.hpp>

#include "fuzz/fuzzing.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  static const fuzz::Folder folder;
  const std::string_view bytes = fuzz::text(data, size);
  const std::string extension = PALPATE_FUZZ_EXTENSION;
  constexpr std::string_view line = "\n----\n";
  const std::size_t cut = extension == ".node" ? bytes.find(line) : std::string_view::npos;
  const auto path = folder.write("mesh" + extension, bytes.substr(0, cut));
  if (extension == ".node")
    folder.write("mesh.ele",
                 cut == std::string_view::npos ? std::string_view{} : bytes.substr(cut + line.size()));
  fuzz::refusing([&] {
    io::MeshFile file = io::read_mesh(path);
    check_mesh(file.mesh, "fuzz");
    Bodies bodies;
    bodies.add("body", std::move(file.mesh));
  });
  return 0;
}
