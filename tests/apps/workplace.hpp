#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/process.hpp"
#include "results/support.hpp"

namespace palpate::test {

using Json = nlohmann::json;

/// A soft box of 3 x 3 x 1 cells that starts 1 mm above a fixed plate; runs fast. `extra` is inserted into
/// the scene verbatim (", \"duration\": 1").
std::string falling_box(const std::string& extra = "");

/// A Medit mesh of one tet with these corners, as text: "x y z" each.
std::string one_tet(const std::vector<std::string>& corners);

std::vector<std::string> lines_of(const std::string& text);
std::vector<std::string> fields_of(const std::string& line);

/// A test in a temporary folder, which is the current folder of the command.
class CommandTest : public ::testing::Test {
 protected:
  [[nodiscard]] Finished palpate(std::vector<std::string> arguments) const {
    return test::palpate(std::move(arguments), folder_.path());
  }
  /// Runs, expects exit code 0 and nothing on stderr but progress, and returns stdout.
  std::string output_of(std::vector<std::string> arguments) const;
  [[nodiscard]] Json json_of(std::vector<std::string> arguments) const;

  /// Expects this exit code, nothing on stdout, and one line "palpate: error: …" that contains all `parts`.
  void expect_error(int exit_code, std::vector<std::string> arguments,
                    const std::vector<std::string>& parts) const;

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    put(folder_ / name, content);
    return folder_ / name;
  }
  [[nodiscard]] std::string read(const std::string& name) const { return content_of(folder_ / name); }
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  TemporaryFolder folder_;
};

}  // namespace palpate::test
