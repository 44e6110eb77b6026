// A table of names and colours of labels.
#include "apps/palpate_mesh/label_table.hpp"
#include "fuzz/fuzzing.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  static const fuzz::Folder folder;
  const auto path = folder.write("labels.txt", fuzz::text(data, size));
  fuzz::refusing([&] { app::read_label_table(path); });
  return 0;
}
