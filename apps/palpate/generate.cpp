#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "exit_codes.hpp"
#include "generate_anatomy.hpp"
#include "generated_file.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "scene/generators.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* generate_examples = R"(Examples:
  palpate generate stacking --count 5 --out five.json
  palpate generate box --cells 20 4 4 --size 0.2 0.04 0.04 --out beam.vtu
  palpate generate ball --radius 0.05 --resolution 8
  palpate generate eye --out eye)";

constexpr const char* stacking_examples = R"(Examples:
  palpate generate stacking                                the paper's scene
  palpate generate stacking --count 3 --cells 4 4 1 --out small.json && palpate run small.json)";

constexpr const char* box_examples = R"(Examples:
  palpate generate box                                     1 x 1 x 1, 10 cells a side
  palpate generate box --cells 20 4 4 --size 0.2 0.04 0.04 --out beam.vtu)";

constexpr const char* ball_examples = R"(Examples:
  palpate generate ball                                    radius 1, 8 layers
  palpate generate ball --radius 0.05 --resolution 16 --out ball.vtu)";

void add_integer(CLI::App& app, const std::string& flag, const std::string& help, int most, int& value) {
  add_value(app, flag, "N", help, [most, &value](const std::string& f, const std::string& text) {
    value = static_cast<int>(parse_integer(f, text, 1, most));
  });
}

Subcommand add_stacking(CLI::App& generate) {
  struct Options {
    StackingOptions stacking;
    GeneratedFile out{"stacking.json", {}};
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = generate.add_subcommand("stacking", "a scene of membranes that fall on each other");
  app->footer(stacking_examples);
  StackingOptions& stacking = options->stacking;
  add_integer(*app, "--count", "membranes; default: 20", 100'000, stacking.count);
  add_triple(*app, "--cells", "NX NY NZ", "cells of a membrane; default: 10 10 1", stacking.cells);
  add_triple(*app, "--size", "X Y Z", "size of a membrane, m; default: 0.2 0.2 0.01", stacking.size);
  add_value(*app, "--gap", "G", "height between membranes at the start, m; default: 0.001",
            [&stacking](const std::string& flag, const std::string& text) {
              stacking.gap = parse_number(flag, text, scene_format::at_least(0.0));
            });
  add_value(*app, "--seed", "N", "of the small shifts and rotations; default: 1",
            [&stacking](const std::string& flag, const std::string& text) {
              constexpr auto most = std::numeric_limits<std::uint32_t>::max();
              stacking.seed = static_cast<std::uint32_t>(parse_integer(flag, text, 0, most));
            });
  add_out(*app, "file to write", options->out);
  return {app, [options] {
            const fs::path path = write_generated(
                options->out, [&] { return write_scene(make_stacking_scene(options->stacking)); });
            const auto count = static_cast<std::size_t>(options->stacking.count);
            print_out(fmt::format("{}: {}\n", path.string(), counted(count, "membrane")));
            return exit_done;
          }};
}

Subcommand add_box(CLI::App& generate) {
  struct Options {
    BoxGenerator box{{10, 10, 10}, {1.0, 1.0, 1.0}};
    GeneratedFile out{"box.vtu", {}};
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = generate.add_subcommand("box", "a mesh: a box around the origin, 5 tets a cell");
  app->footer(box_examples);
  add_triple(*app, "--cells", "NX NY NZ", "cells along each axis; default: 10 10 10", options->box.cells);
  add_triple(*app, "--size", "X Y Z", "size along each axis; default: 1 1 1", options->box.size);
  add_out(*app, "file to write", options->out);
  return {app, [options] {
            write_generated_mesh(options->out,
                                 [&] { return make_box(options->box.cells, options->box.size); });
            return exit_done;
          }};
}

Subcommand add_ball(CLI::App& generate) {
  struct Options {
    BallGenerator ball{1.0, 8};
    GeneratedFile out{"ball.vtu", {}};
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = generate.add_subcommand("ball", "a mesh: a ball around the origin");
  app->footer(ball_examples);
  add_value(*app, "--radius", "R", "radius; default: 1",
            [&ball = options->ball](const std::string& flag, const std::string& text) {
              ball.radius = parse_number(flag, text, scene_format::above(0.0));
            });
  add_integer(*app, "--resolution", "layers n from centre to surface, 20 n^3 tets; default: 8",
              most_ball_resolution, options->ball.resolution);
  add_out(*app, "file to write", options->out);
  return {app, [options] {
            write_generated_mesh(options->out,
                                 [&] { return make_ball(options->ball.radius, options->ball.resolution); });
            return exit_done;
          }};
}

}  // namespace

std::vector<Subcommand> add_generate(CLI::App& command) {
  CLI::App* generate = command.add_subcommand("generate", "write an example scene or mesh");
  generate->footer(generate_examples);
  generate->require_subcommand(1);
  std::vector<Subcommand> all = add_generate_anatomy(*generate);
  all.insert(all.begin(), {add_stacking(*generate), add_box(*generate), add_ball(*generate)});
  return all;
}

}  // namespace palpate::app
