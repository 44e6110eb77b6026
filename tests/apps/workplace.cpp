#include "apps/workplace.hpp"

#include <sstream>

namespace palpate::test {

std::string falling_box(const std::string& extra) {
  return R"({"name": "falling box", "time_step": 0.01, "duration": 0.1)" + extra + R"(,
  "output": {"every": 4, "picture": {"size": [160, 120]}},
  "bodies": [
    {"name": "plate", "box": {"cells": [2, 2, 1], "size": [0.2, 0.2, 0.02]}, "translate": [0, 0, -0.01], "obstacle": true},
    {"name": "box", "box": {"cells": [3, 3, 1], "size": [0.06, 0.06, 0.02]}, "rotate": {"angle": 10},
     "translate": [0.003, 0.002, 0.011], "material": {"young_modulus": 20000, "mass_damping": 1, "stiffness_damping": 0.002}}
  ]})";
}

std::string one_tet(const std::vector<std::string>& corners) {
  std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n";
  for (const std::string& corner : corners) text += corner + " 0\n";
  return text + "Tetrahedra\n1\n1 2 3 4 0\nEnd\n";
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

std::string CommandTest::output_of(std::vector<std::string> arguments) const {
  const Finished finished = palpate(std::move(arguments));
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_EQ(finished.err.find("error"), std::string::npos) << finished.err;
  return finished.out;
}

Json CommandTest::json_of(std::vector<std::string> arguments) const {
  return Json::parse(output_of(std::move(arguments)));
}

void CommandTest::expect_error(int exit_code, std::vector<std::string> arguments,
                               const std::vector<std::string>& parts) const {
  const Finished finished = palpate(std::move(arguments));
  EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
  EXPECT_EQ(finished.out, "");
  EXPECT_EQ(lines_of(finished.err).size(), 1U) << finished.err;
  EXPECT_TRUE(finished.err.starts_with("palpate: error: ")) << finished.err;
  EXPECT_TRUE(finished.err.ends_with('\n'));
  for (const std::string& part : parts) {
    EXPECT_NE(finished.err.find(part), std::string::npos) << part << " is not in: " << finished.err;
  }
}

}  // namespace palpate::test
