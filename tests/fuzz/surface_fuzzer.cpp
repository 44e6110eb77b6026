// A surface mesh of one format, given by PALPATE_FUZZ_EXTENSION.
#include <algorithm>
#include <string>

#include "apps/palpate_mesh/surface_file.hpp"
#include "fuzz/fuzzing.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  static const fuzz::Folder folder;
  const auto path = folder.write(std::string("surface") + PALPATE_FUZZ_EXTENSION, fuzz::text(data, size));
  fuzz::refusing([&] {
    const app::PolygonFile file = app::read_surface_file(path);
    for (const std::vector<Index>& polygon : file.polygons) {
      fuzz::require(std::ranges::all_of(polygon, [&](Index point) {
        return point >= 0 && static_cast<std::size_t>(point) < file.points.size();
      }));
    }
  });
  return 0;
}
