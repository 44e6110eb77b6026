#include <cmath>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Detect : public CommandTest {
 protected:
  /// A cube with its top at z = 0.5, and a tet whose lowest corner (0.1, 0.1, 0.4) is in it: 0.1 deep, pushed
  /// up.
  void SetUp() override {
    write("tet.mesh", one_tet({"0.1 0.1 0.4", "0.3 0.1 1", "0.1 0.3 1", "0.1 0.1 1"}));
    write("scene.json", R"({"bodies": [
      {"name": "cube", "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "obstacle": true},
      {"name": "tet", "mesh": "tet.mesh", "material": {}}]})");
  }
};

TEST_F(Detect, PlacesPrescribedBodiesAsAtTheStartOfARun) {
  const auto contacts = [&](const std::string& translate) {
    write("pose.json", R"({"bodies": [
      {"name": "plate", "box": {"cells": [4, 4, 1], "size": [0.4, 0.4, 0.04]},
       "motion": {"keyframes": [{"time": 0, "translate": )" +
                           translate + R"(}]}},
      {"name": "ball", "ball": {"radius": 0.04, "resolution": 4}, "translate": [0, 0, 0.07], "material": {}}]})");
    return lines_of(palpate({"detect", "pose.json"}).out).size() - 1;
  };
  EXPECT_EQ(contacts("[0, 0, 0]"), 0U) << "1 cm apart";
  EXPECT_GT(contacts("[0, 0, 0.045]"), 10U);
}

TEST_F(Detect, WritesTheContactThatIsThere) {
  const Finished done = palpate({"detect", "scene.json"});
  EXPECT_EQ(done.exit_code, 0);
  const auto lines = lines_of(done.out);
  ASSERT_EQ(lines.size(), 2U) << done.out;
  EXPECT_EQ(lines[0],
            "point,point_body,body,tet,weight_0,weight_1,weight_2,weight_3,depth,direction_x,direction_y,"
            "direction_z");
  const auto fields = fields_of(lines[1]);
  ASSERT_EQ(fields.size(), 12U);
  EXPECT_EQ(fields[0], "8") << "after the cube's eight points";
  EXPECT_EQ(fields[1], "1");
  EXPECT_EQ(fields[2], "0");
  double sum = 0.0;
  for (std::size_t i = 4; i < 8; ++i) {
    EXPECT_GE(std::stod(fields[i]), 0.0);
    sum += std::stod(fields[i]);
  }
  EXPECT_NEAR(sum, 1.0, 1e-14);
  EXPECT_NEAR(std::stod(fields[8]), 0.1, 1e-14);
  EXPECT_NEAR(std::stod(fields[9]), 0.0, 1e-14);
  EXPECT_NEAR(std::stod(fields[10]), 0.0, 1e-14);
  EXPECT_NEAR(std::stod(fields[11]), 1.0, 1e-14);
  EXPECT_TRUE(done.err.starts_with("palpate: 1 contact, 3 border edges, 3 crossings")) << done.err;
}

TEST_F(Detect, JsonHoldsTheSameBitsAsCsv) {
  const auto fields = fields_of(lines_of(output_of({"detect", "scene.json"})).at(1));
  const Json json = json_of({"detect", "scene.json", "--format", "json"});
  EXPECT_EQ(json["length_unit"], "m");
  EXPECT_EQ(json["bodies"][1]["name"], "tet");
  EXPECT_EQ(json["bodies"][1]["points"], Json::parse("[8, 12]"));
  EXPECT_EQ(json["bodies"][1]["tets"], Json::parse("[5, 6]"));
  ASSERT_EQ(json["contacts"].size(), 1U);
  const Json& contact = json["contacts"][0];
  EXPECT_EQ(contact["point"], std::stoi(fields[0]));
  EXPECT_EQ(contact["point_body"], 1);
  EXPECT_EQ(contact["body"], 0);
  EXPECT_EQ(contact["tet"], std::stoi(fields[3]));
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(contact["weights"][i].get<double>(), std::stod(fields[4 + i]));
  EXPECT_EQ(contact["depth"].get<double>(), std::stod(fields[8]));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(contact["direction"][i].get<double>(), std::stod(fields[9 + i]));
}

TEST_F(Detect, SaysWhatABudgetLeftOut) {
  const auto scene = [](const std::string& tests) {
    return R"({"contact": {"budget": {"tests": )" + tests + R"(}}, "bodies": [
      {"name": "left", "ball": {"radius": 1, "resolution": 8}, "material": {}},
      {"name": "right", "ball": {"radius": 1, "resolution": 8}, "translate": [1.8, 0, 0], "material": {}}]})";
  };
  write("small.json", scene("1"));
  const Finished done = palpate({"detect", "small.json", "--format", "json"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_NE(done.err.find("the budget was too small: "), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("contacts may be missing in left, right\n"), std::string::npos) << done.err;
  const Json small = Json::parse(done.out);
  EXPECT_LT(small["completeness"].get<double>(), 1.0);
  EXPECT_EQ(small["late_bodies"], Json::parse(R"(["left", "right"])"));
  write("large.json", scene("10000000"));
  const Json large = Json::parse(palpate({"detect", "large.json", "--format", "json"}).out);
  EXPECT_EQ(large["completeness"], 1.0);
  EXPECT_EQ(large["late_bodies"], Json::array());
  EXPECT_GT(large["contacts"].size(), small["contacts"].size());
  EXPECT_FALSE(json_of({"detect", "scene.json", "--format", "json"}).contains("completeness"));
  write("rough.json", R"({"bodies": [
      {"name": "left", "ball": {"radius": 1, "resolution": 8}, "material": {}},
      {"name": "right", "ball": {"radius": 1, "resolution": 8}, "translate": [1.8, 0, 0], "material": {}}]})");
  const Finished rough = palpate({"detect", "rough.json", "--cells-per-primitive", "1", "--format", "json"});
  EXPECT_NE(rough.err.find("the limit of cells per primitive left out "), std::string::npos) << rough.err;
  EXPECT_GT(Json::parse(rough.out)["dropped_cells"], 0);
}

TEST_F(Detect, DoesNotDependOnStructureThreadsOrCellSize) {
  output_of({"generate", "stacking", "--count", "4", "--cells", "5", "5", "1", "--size", "0.1", "0.1", "0.02",
             "--gap", "0", "--out", "stack.json"});
  std::string text = read("stack.json");  // membranes half sunk into each other
  for (const auto& [from, to] : {std::pair{"0.03]", "0.025]"}, {"0.05]", "0.035]"}, {"0.07]", "0.045]"}}) {
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << text;
    text.replace(place, std::string(from).size(), to);
  }
  write("stack.json", text);
  const std::string contacts = output_of({"detect", "stack.json"});
  EXPECT_GT(lines_of(contacts).size(), 100U);
  EXPECT_EQ(output_of({"detect", "stack.json", "--structure", "brute"}), contacts);
  EXPECT_EQ(output_of({"detect", "stack.json", "--threads", "3", "--cell-size", "0.007"}), contacts);
  EXPECT_EQ(output_of({"detect", "stack.json", "--cell-size", "1e-300"}), contacts);
  EXPECT_EQ(output_of({"detect", "stack.json", "--out", "contacts.csv"}), "");
  EXPECT_EQ(read("contacts.csv"), contacts);
}

TEST_F(Detect, SaysWhatIsWrong) {
  expect_error(2, {"detect", "missing.json"}, {"missing.json"});
  expect_error(1, {"detect", "scene.json", "--out", "no/such/file.csv"}, {"no/such/file.csv"});
  expect_error(2, {"detect", "tet.mesh"}, {"tet.mesh", "a mesh file", "a scene file"});
  const std::string scene = read("scene.json");
  expect_error(2, {"detect", "scene.json", "--out", "./scene.json"},
               {"--out: found ./scene.json, which is read, expected another file"});
  EXPECT_EQ(read("scene.json"), scene);
}

}  // namespace
}  // namespace palpate::test
