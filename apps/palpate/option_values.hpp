#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

#include "scene/first_scene.hpp"
#include "scene/limits.hpp"

/// Parsers of flag values. Each throws BadInput "FLAG: found 'TEXT', expected …"; the whole text must be the
/// value.
namespace palpate::app {

std::int64_t parse_integer(const std::string& flag, const std::string& text, std::int64_t low,
                           std::int64_t high);
double parse_number(const std::string& flag, const std::string& text, const scene_format::Limits& limits);
/// The index of `text` in `names`.
std::size_t parse_choice(const std::string& flag, const std::string& text,
                         std::span<const std::string_view> names);
/// One of "m", "cm", "mm" and "um".
MeshUnit parse_mesh_unit(const std::string& flag, const std::string& text);

/// Adds `flag` with one value, for which `parse(flag, text)` is called.
CLI::Option* add_value(CLI::App& app, const std::string& flag, const std::string& type,
                       const std::string& help,
                       std::function<void(const std::string&, const std::string&)> parse);

/// Adds the required positional argument `name`.
CLI::Option* add_path(CLI::App& app, const std::string& name, std::filesystem::path& path,
                      const std::string& help);

/// Adds a flag that may be given several times, each with one value.
CLI::Option* add_repeated(CLI::App& app, const std::string& flag, const std::string& type,
                          const std::string& help,
                          std::function<void(const std::string&, const std::string&)> given);

/// Adds `--set KEY=VALUE`.
CLI::Option* add_changes(CLI::App& app, std::vector<std::string>& changes);

/// Adds `--threads N`.
void add_threads(CLI::App& app, int& threads);
/// Adds `--json`.
void add_json(CLI::App& app, bool& json, const std::string& help);

/// Adds `flag` with three integers >= 1, or three numbers > 0.
void add_triple(CLI::App& app, const std::string& flag, const std::string& type, const std::string& help,
                std::array<int, 3>& values);
void add_triple(CLI::App& app, const std::string& flag, const std::string& type, const std::string& help,
                Vec3& values);

}  // namespace palpate::app
