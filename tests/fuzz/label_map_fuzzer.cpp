// A label map of one format, given by PALPATE_FUZZ_EXTENSION. ITK reads it and is not instrumented: our code
// alone guides the search, but memory errors of its readers still show.
#include "apps/palpate_mesh/label_map.hpp"
#include "fuzz/fuzzing.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  static const fuzz::Folder folder;
  const auto path = folder.write(std::string("map") + PALPATE_FUZZ_EXTENSION, fuzz::text(data, size));
  fuzz::refusing([&] {
    const app::LabelMap map = app::read_label_map(path);
    for (const app::LabelExtent& extent : app::labels_in(map)) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        fuzz::require(0 <= extent.box.lower[a] && extent.box.upper[a] < map.size[a]);
      }
    }
  });
  return 0;
}
