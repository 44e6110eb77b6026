#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <palpate/mesh.hpp>

#include "interrupt.hpp"

namespace palpate::app {

/// The file that `palpate generate KIND` writes. A file that the user names is replaced, the default name is
/// not.
struct GeneratedFile {
  std::filesystem::path default_name;
  std::optional<std::filesystem::path> named;

  /// Throws BadInput if the default name exists, or on a name with another extension than the default one.
  [[nodiscard]] std::filesystem::path path() const;
};

/// Adds `--out FILE`. `help` says what is written: "file to write".
void add_out(CLI::App& app, const std::string& help, GeneratedFile& file);

/// Throws std::runtime_error "interrupted; STATE" after a signal.
void stop_if_interrupted(const InterruptFlag& interrupt, const std::string& state);

/// Returns make(). A signal meanwhile ends the process: nothing is written yet.
template <class Make>
auto made(Make&& make) {
  const InterruptEnd end("palpate: error: interrupted; nothing was written\n");
  return make();
}

/// Makes a text and writes it, unless a signal comes before; returns the path. An Error of `make` is
/// BadInput. Throws after a signal, also one that comes too late.
std::filesystem::path write_generated(const GeneratedFile& file, const std::function<std::string()>& make);
/// The same for a mesh (.vtu); prints the path and the counts.
void write_generated_mesh(const GeneratedFile& file, const std::function<TetMesh()>& make);

/// Writes a mesh to a file (.vtu), and prints its name and counts.
void write_mesh(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::app
