// Checkpoint files of the command: as files, and as content with a valid checksum.
#include <vector>

#include "apps/palpate/checkpoint.hpp"
#include "apps/palpate/exit_codes.hpp"
#include "fuzz/fuzzing.hpp"
#include "scene/scene.hpp"
#include "sim/archive.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  static const fuzz::Folder folder;
  std::filesystem::create_directories(folder.path() / "checkpoints");
  const auto look = [&](std::string_view bytes) {
    folder.write("checkpoints/step_000000001.palpate", bytes);
    fuzz::refusing([&] {
      try {
        const app::RunPlan plan = app::find_checkpoint(folder.path()).checkpoint.plan;
        read_scene_text(plan.scene, plan.source, plan.scene_folder);
      } catch (const app::BadInput&) {  // as the command would say
      }
    });
  };
  look(fuzz::text(data, size));
  const auto bytes = sealed(app::checkpoint_seal, std::as_bytes(std::span(data, size)));
  look({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return 0;
}
