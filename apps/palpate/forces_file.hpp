#pragma once

#include <cstdint>
#include <filesystem>

#include "body_forces.hpp"
#include "csv_file.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// forces.csv: a header with units, then a row for each step. A row has, for each body, the force and torque
/// by contacts; for bodies with held points also the force and torque that hold them, and for tied and
/// grabbed bodies those of ties and grabs; and for each pair that the scene names, the force and torque of
/// the first body on the second. Torques are about centres of mass.
class ForcesFile {
 public:
  /// Creates or continues the file, as the constructors of CsvFile do.
  ForcesFile(std::filesystem::path path, const ForceProbe& probe, const Units& units);
  ForcesFile(std::filesystem::path path, std::uint64_t bytes);

  /// Adds a row for the last step.
  /// \param forces  what the probe found
  void add(const Simulation& simulation, const ForcesOfStep& forces);
  void flush() { file_.flush(); }
  void sync() { file_.sync(); }
  [[nodiscard]] std::uint64_t bytes() const { return file_.bytes(); }

 private:
  CsvFile file_;
};

}  // namespace palpate::app
