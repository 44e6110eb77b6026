// The first minutes with the command: from a mesh to a scene, and the messages.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>

#include <palpate/version.hpp>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Door : public CommandTest {
 protected:
  /// A block of 210 x 100 x 60 without a unit in its file: 1.26 kg in mm with the density of water.
  void make_liver() const {
    output_of(
        {"generate", "box", "--cells", "7", "4", "3", "--size", "210", "100", "60", "--out", "liver.vtu"});
  }
  /// Output of a shell that runs `line` in the folder of the test; "palpate" is the command.
  [[nodiscard]] std::string shell(const std::string& line) const {
    const std::string call =
        "cd '" + folder_.path().string() + "'; palpate() { '" PALPATE_COMMAND "' \"$@\"; }; " + line;
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(call.c_str(), "r"), ::pclose);
    std::string text;
    std::array<char, 4096> bytes{};
    while (const std::size_t count = std::fread(bytes.data(), 1, bytes.size(), pipe.get()))
      text.append(bytes.data(), count);
    return text;
  }
};

/// What a run of the scene of a mesh shows at its end.
void expect_pressed(const Json& report, bool dropped) {
  EXPECT_EQ(report["inverted_tets"]["last"], 0);
  EXPECT_EQ(report["solver"]["steps_not_converged"], 0);
  EXPECT_EQ(report["steps_too_far"], 0);
  EXPECT_GT(report["contacts"]["last"].get<int>() + report["edge_contacts"]["last"].get<int>(), 0)
      << "the picture at the end shows the instrument at work";
  const double weight = report["bodies"][0]["mass"].get<double>() * 9.81;
  const auto up = [&](std::size_t body) { return report["bodies"][body]["contact_force"][2].get<double>(); };
  EXPECT_GT(up(2), 0.1 * weight) << "the instrument is pushed up";
  if (dropped) {
    EXPECT_NEAR(-up(1), up(2) + weight, 0.3 * weight) << "the floor bears the weight and the press";
    return;
  }
  const double height =
      report["bodies"][0]["upper"][2].get<double>() - report["bodies"][0]["lower"][2].get<double>();
  EXPECT_GT(report["bodies"][0]["displacement"]["largest"].get<double>(), 0.02 * height) << "it is seen";
}

TEST_F(Door, NewMakesASceneOfAMeshThatRunsAtOnce) {
  make_liver();
  const Finished made = palpate({"new", "liver.vtu"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_TRUE(made.out.starts_with("liver.json: liver.vtu in mm: 0.21 m, 1.3 kg; ")) << made.out;
  EXPECT_EQ(made.err,
            "palpate: unit guessed: mm (choose with --unit)\n"
            "palpate: young_modulus is 32 kPa, the softest that keeps the shape of this body under its "
            "weight; set it to that of the tissue\n"
            "palpate: next: 'palpate view liver.json' shows it and lets you pull at it, "
            "'palpate run liver.json' simulates it\n");
  const Json report = json_of({"run", "liver.json", "--json", "--no-picture"});
  expect_pressed(report, false);
  EXPECT_EQ(report["inverted_tets"]["largest"], 0);
  EXPECT_EQ(report["bodies"].size(), 3U);
  EXPECT_NEAR(report["bodies"][0]["mass"].get<double>(), 1.26, 1e-9);
  // The lowest tenth is held: gravity and the instrument move its surface by much less than its height of 60
  // mm.
  EXPECT_LT(report["bodies"][0]["displacement"]["largest"].get<double>(), 0.02);
}

TEST_F(Door, AnInstrumentPressesMeshesOfEveryShape) {
  // A standing ring, a bowl of a sheet with a hole, a strap, a jaw, a flat beam; one is named as the floor
  // is. Nothing touched the first four while they were as soft as others.
  for (const char* mesh : {"eye/skin", "eye/plate", "eye/rectus-inferior", "skull/lower-jaw", "cook/cook",
                           "orbit-repair/floor"}) {
    for (const bool dropped : {false, true}) {
      SCOPED_TRACE(std::string(mesh) + (dropped ? ", dropped" : ", held"));
      std::vector<std::string> call{
          "new",        PALPATE_SOURCE_DIR "/scenes/meshes/" + std::string(mesh) + ".vtu",
          "--yes",      "--out",
          "trial.json", "--replace"};
      if (dropped) call.emplace_back("--drop");
      output_of(call);
      expect_pressed(json_of({"run", "trial.json", "--json", "--no-picture", "--replace"}), dropped);
    }
  }
}

TEST_F(Door, NewMakesASceneOfALiverWithThinRimsThroughWhichNothingPasses) {
  output_of({"new", PALPATE_SOURCE_DIR "/examples/push/liver.vtu", "--out", "liver.json"});
  const std::vector<std::string> run{"run", "liver.json", "--json", "--no-picture", "--replace"};
  expect_pressed(json_of(run), false);
  output_of(
      {"new", PALPATE_SOURCE_DIR "/examples/push/liver.vtu", "--out", "liver.json", "--drop", "--replace"});
  expect_pressed(json_of(run), true);
  std::vector<std::string> at_ends_of_steps = run;
  for (const char* word : {"--set", "contact.continuous=off"}) at_ends_of_steps.emplace_back(word);
  EXPECT_GT(json_of(at_ends_of_steps)["steps_too_far"], 0) << "what the key is for";
}

TEST_F(Door, NewTakesWhatItIsTold) {
  make_liver();
  const auto said = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"new", "liver.vtu", "--replace", "--out", "scene.json"});
    return output_of(flags);
  };
  EXPECT_NE(said({"--unit", "cm"}).find("in cm: 2.1 m, 1.3 tonnes"), std::string::npos);
  EXPECT_NE(said({"--size", "0.105"}).find("scaled by 0.0005: 0.1 m, 0.16 kg"), std::string::npos);
  EXPECT_NE(said({"--drop"}).find("it falls onto a floor, and then a plate presses it"), std::string::npos);
  const Json camera = Json::parse(read("scene.json"))["output"]["picture"]["camera"];
  EXPECT_LT(camera["position"][2], 0.06) << "below the plate that lies on it at the end";
  const Json dropped = json_of({"run", "scene.json", "--json", "--no-picture", "--steps", "40"});
  EXPECT_GT(dropped["contacts"]["last"], 0) << "it lies on the floor";
  EXPECT_GT(dropped["bodies"][0]["displacement"]["largest"].get<double>(), 0.005) << "it fell by 6 mm";
}

TEST_F(Door, NewWritesWhatIsWorthChanging) {
  make_liver();
  output_of({"new", "liver.vtu"});
  const Json scene = Json::parse(read("liver.json"));
  for (const char* key : {"units", "time_step", "duration", "gravity"})
    EXPECT_TRUE(scene.contains(key)) << key;
  for (const char* key : {"solver", "rest", "limits"}) EXPECT_FALSE(scene.contains(key)) << key;
  EXPECT_EQ(scene["contact"], Json({{"friction", 0.3}}));
  EXPECT_EQ(scene["output"], Json({{"every", 5}}));
  const Json material = scene["bodies"][0]["material"];
  for (const char* key : {"young_modulus", "poisson_ratio", "density"})
    EXPECT_TRUE(material.contains(key)) << key;
  EXPECT_FALSE(material.contains("mooney_fraction"));
}

/// The number of significant digits of a number as it is written, such as 3 of "0.00120".
std::size_t significant_digits(const std::string& number) {
  std::string digits = number.substr(0, number.find('e'));
  std::erase_if(digits, [](char c) { return c < '0' || c > '9'; });
  const std::size_t first = digits.find_first_not_of('0');
  return first == std::string::npos ? 0 : digits.find_last_not_of('0') + 1 - first;
}

/// Appends the numbers of a JSON value as they are written.
void collect_numbers(const Json& value, std::vector<std::string>& texts) {
  if (value.is_number()) texts.push_back(value.dump());
  if (value.is_structured()) {
    for (const Json& item : value) collect_numbers(item, texts);
  }
}

TEST_F(Door, NewWritesNumbersThatAPersonWouldWrite) {
  // Boxes are symmetric about the origin: without rounding their centres are some 1e-18.
  output_of({"generate", "box", "--cells", "7", "4", "3", "--size", "0.2100001", "0.0870013", "0.0575194",
             "--out", "box.vtu"});
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{}, {"--drop"}, {"--size", "0.173"}, {"--unit", "cm"}}) {
    for (const char* mesh : {"box.vtu", PALPATE_SOURCE_DIR "/examples/push/liver.vtu",
                             PALPATE_SOURCE_DIR "/scenes/meshes/eye/skin.vtu"}) {
      std::vector<std::string> call{"new", mesh, "--out", "trial.json", "--replace"};
      call.insert(call.end(), flags.begin(), flags.end());
      output_of(call);
      std::vector<std::string> numbers;
      collect_numbers(Json::parse(read("trial.json")), numbers);
      ASSERT_GT(numbers.size(), 20U);
      for (const std::string& number : numbers) {
        EXPECT_LE(significant_digits(number), 7U) << number << " of " << mesh;
        const double size = std::abs(std::stod(number));
        EXPECT_TRUE(size == 0.0 || size > 1e-7) << number << " of " << mesh;
      }
    }
  }
}

TEST_F(Door, NewSaysWhatItGuessedAndWhatItChose) {
  make_liver();
  output_of({"generate", "ball", "--radius", "0.5", "--resolution", "2"});
  output_of({"generate", "box", "--cells", "1", "1", "9", "--size", "10", "10", "300", "--out", "strap.vtu"});
  const auto said = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "new");
    words.insert(words.end(), {"--out", "trial.json", "--replace"});
    return palpate(words).err;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(said({"ball.vtu"}),
                  "palpate: no unit fits a length of 1: scaled to 0.1 m (choose with --unit or --size)\n"));
  EXPECT_TRUE(has(said({"liver.vtu", "--yes"}), "unit guessed: mm"));
  for (const std::vector<std::string>& told :
       std::vector<std::vector<std::string>>{{"--unit", "mm"}, {"--size", "0.2"}})
    EXPECT_FALSE(has(said({"liver.vtu", told[0], told[1]}), "guessed")) << told[0];
  const std::string stiff = said({"strap.vtu", "--unit", "mm", "--drop"});
  const double modulus = Json::parse(read("trial.json"))["bodies"][0]["material"]["young_modulus"];
  ASSERT_GT(modulus, 20e3) << "this body is slender";
  const std::size_t at = stiff.find("young_modulus is ");
  ASSERT_NE(at, std::string::npos) << stiff;
  EXPECT_NEAR(std::stod(stiff.substr(at + 17)), 1e-3 * modulus, 1e-5 * modulus);
  EXPECT_TRUE(has(said({"ball.vtu", "--size", "0.02"}),
                  "young_modulus is 20 kPa, as of a soft organ; set it to that of the tissue\n"));
  EXPECT_TRUE(has(stiff, " kPa, the softest that keeps the shape of this body under its weight; set it"))
      << stiff;
  EXPECT_TRUE(has(said({PALPATE_SOURCE_DIR "/scenes/meshes/eye/skin.vtu", "--unit", "cm"}),
                  "young_modulus is 1.42 MPa, the softest"));
}

TEST_F(Door, HintsOfFilesThatBeginWithADashAreNoFlags) {
  make_liver();
  std::filesystem::rename(folder_ / "liver.vtu", folder_ / "-dash.vtu");
  EXPECT_NE(palpate({"new", "./-dash.vtu"})
                .err.find("'palpate view ./-dash.json' shows it and lets you pull at it, "
                          "'palpate run ./-dash.json' simulates it\n"),
            std::string::npos);
  EXPECT_NE(shell("palpate info ./-dash.json").find("scene '-dash'"), std::string::npos);
}

TEST_F(Door, ViewOfAFolderThatIsNoRunSaysSo) {
  std::filesystem::create_directories(folder_ / "results" / "fall");
  expect_error(2, {"view", "results"},
               {"results: found a folder without run.json, expected the folder of a run"});
  write("results/fall/run.json", "{}");
  expect_error(2, {"view", "results"},
               {"results: found a folder without run.json, expected the folder of a run, as results/fall"});
}

TEST_F(Door, NewNamesTheMeshFromWhereTheSceneIs) {
  make_liver();
  std::filesystem::create_directory(folder_ / "scenes");
  output_of({"new", "liver.vtu", "--out", "scenes/trial.json"});
  EXPECT_EQ(Json::parse(read("scenes/trial.json"))["bodies"][0]["mesh"], "../liver.vtu");
  output_of({"run", "scenes/trial.json", "--steps", "1", "--no-picture"});
}

TEST_F(Door, AMeshWithoutAUnitBecomesAsLargeAsAHand) {
  output_of({"generate", "ball", "--radius", "0.5", "--resolution", "2"});
  EXPECT_NE(output_of({"new", "ball.vtu"}).find("ball.vtu scaled by 0.1: 0.1 m, "), std::string::npos);
}

TEST_F(Door, HintsCanBeCopiedWhateverTheFileIsNamed) {
  make_liver();
  std::filesystem::rename(folder_ / "liver.vtu", folder_ / "my liver.vtu");
  EXPECT_EQ(palpate({"new", "my liver.vtu", "--unit", "mm"}).err,
            "palpate: young_modulus is 32 kPa, the softest that keeps the shape of this body under its "
            "weight; set it to that of the tissue\n"
            "palpate: next: \"palpate view 'my liver.json'\" shows it and lets you pull at it, "
            "\"palpate run 'my liver.json'\" simulates it\n");
  EXPECT_NE(palpate({"info", "my liver.vtu"}).err.find("\"palpate new 'my liver.vtu'\" makes a scene of it"),
            std::string::npos);
  const std::string refused = palpate({"run", "my liver.vtu"}).err;
  const std::string before = "make one with: ";
  const std::size_t hint = refused.find(before);
  ASSERT_NE(hint, std::string::npos) << refused;
  // The shell is the judge of the quotes.
  EXPECT_EQ(shell(refused.substr(hint + before.size(), refused.find('\n') - hint - before.size()) +
                  " --yes --out copied.json 2>/dev/null")
                .rfind("copied.json: my liver.vtu in mm", 0),
            0U);
  write("it's.stl", "solid");
  expect_error(2, {"run", "it's.stl"}, {"palpate mesh 'it'\\''s.stl'"});
  write("my skin.stl", "solid");
  expect_error(2, {"run", "my skin.stl"}, {"palpate mesh 'my skin.stl'"});
}

TEST_F(Door, NewRefusesInOneLineAndSaysWhatToDo) {
  make_liver();
  write("liver.json", "mine");
  write("skin.stl", "solid");
  expect_error(2, {"new", "liver.vtu"}, {"liver.json: found an existing file", "--replace", "--out"});
  expect_error(2, {"new", "liver.vtu", "--out", "liver.json"}, {"liver.json: found an existing file"});
  EXPECT_EQ(read("liver.json"), "mine");
  expect_error(2, {"new", "skin.stl"}, {"skin.stl", "'palpate mesh'"});
  expect_error(
      2, {"new", "liver.json"},
      {"liver.json: found a file that is a scene already, expected a mesh of tets; 'palpate view liver.json'",
       "'palpate run liver.json' simulates it"});
  expect_error(2, {"new", "none.json"}, {"none.json", "'.json'"});
  expect_error(2, {"new", "none.vtu"}, {"none.vtu: found no such file"});
  expect_error(2, {"new", "liver.vtu", "--out", "no/x.json"}, {"--out: found no folder 'no'"});
  expect_error(2, {"new", "liver.vtu", "--out", "x.txt"}, {"'x.txt'", ".json"});
  expect_error(2, {"new", "liver.vtu", "--unit", "km"},
               {"--unit: found 'km', expected one of 'm', 'cm', 'mm', 'um'"});
  expect_error(2, {"new", "liver.vtu", "--unit", "mm", "--size", "1"}, {"--size", "--unit"});
  output_of({"new", "liver.vtu", "--replace"});
  EXPECT_EQ(Json::parse(read("liver.json"))["name"], "liver");
  expect_error(2, {"run", "liver.vtu"}, {"liver.vtu: found a mesh file", "palpate new liver.vtu"});
  expect_error(2, {"run", "skin.stl"}, {"skin.stl: found a surface", "palpate mesh skin.stl"});
  expect_error(2, {"detect", "head.nii.gz"}, {"head.nii.gz: found a label map", "palpate mesh head.nii.gz"});
}

TEST_F(Door, NewAsksOnATerminal) {
  make_liver();
  const auto answered = [&](const std::string& typed) {
    std::filesystem::remove(folder_ / "liver.json");
    return palpate_on_terminal({"new", "liver.vtu"}, folder_.path(), 200, typed);
  };
  const std::string agreed = answered("\n");
  EXPECT_NE(agreed.find("liver.vtu is 210 long: in mm, this is 0.21 m and 1.3 kg."), std::string::npos)
      << agreed;
  EXPECT_NE(agreed.find("liver.vtu in mm: 0.21 m"), std::string::npos) << agreed;
  EXPECT_NE(answered("cm\n").find("in cm: 2.1 m"), std::string::npos);
  EXPECT_NE(answered("0.3\n").find(": 0.3 m, "), std::string::npos);
  for (const char* yes : {"y\n", "yes\n", " Y \n"})
    EXPECT_NE(answered(yes).find("liver.vtu in mm: 0.21 m"), std::string::npos) << yes;
  const std::string again = answered("elephant\n-1\ncm\n");
  EXPECT_NE(again.find("found 'elephant', expected y, m, cm, mm, um"), std::string::npos) << again;
  EXPECT_NE(again.find("found '-1'"), std::string::npos) << again;
  EXPECT_NE(again.find("in cm: 2.1 m"), std::string::npos) << again;
  EXPECT_NE(answered("elephant\nno\ngnu\ncm\n").find("the answer: found 'gnu'"), std::string::npos);
  EXPECT_FALSE(exists("liver.json"));
  EXPECT_NE(answered("\x04").find("the end of the input"), std::string::npos);  // Ctrl-D
}

TEST_F(Door, WarnsOfBodiesThatAreOfNoHumanSize) {
  const auto box = [](const std::string& size) {
    return R"({"bodies": [{"name": "liver", "material": {}, "box": {"cells": [1, 1, 1], "size": [)" + size +
           "]}}]}";
  };
  write("large.json", box("6, 2.5, 2.5"));
  write("small.json", box("1e-4, 1e-4, 1e-4"));
  write("right.json", box("0.2, 0.1, 0.1"));
  // A box of water as above, in kilometres, micrograms and seconds: 1000 kg/m^3 is 1e21 ug/km^3.
  const auto in_km = [&](const std::string& size) {
    return R"({"units": {"length": "km", "mass": "ug", "time": "s"}, "gravity": [0, 0, 0], "bodies": [{"name": "liver",
      "material": {"young_modulus": 1e17, "density": 1e21}, "box": {"cells": [1, 1, 1], "size": [)" +
           size + "]}}]}";
  };
  write("large_in_km.json", in_km("6e-3, 2.5e-3, 2.5e-3"));
  write("right_in_km.json", in_km("2e-4, 1e-4, 1e-4"));
  const auto said = [&](const std::string& file) { return palpate({"info", file}).err; };
  EXPECT_EQ(said("large.json"),
            "palpate: warning: 'liver' is 6 m long and weighs 38 tonnes: is its mesh in other units "
            "than the scene? The body's \"scale\" makes it smaller\n");
  EXPECT_EQ(said("large_in_km.json"), said("large.json"));
  EXPECT_EQ(said("right_in_km.json"), "");
  EXPECT_NE(said("small.json").find("'liver' is 0.1 mm long"), std::string::npos);
  EXPECT_EQ(said("right.json"), "");
}

TEST_F(Door, SetTakesThePlaceOfValuesOfTheScene) {
  write("scene.json", falling_box());
  const Json scene =
      json_of({"run", "scene.json", "--json", "--no-picture", "--set", "duration=0.03", "--set",
               "contact.friction=0.25", "--set", "bodies.box.material.density=800", "--set",
               "bodies[0].color=[1, 0, 0]", "--set", "contact.structure=hash"})["scene"];
  EXPECT_EQ(scene["duration"], 0.03);
  EXPECT_EQ(scene["contact"]["friction"], 0.25);
  EXPECT_EQ(scene["contact"]["structure"], "hash");
  EXPECT_EQ(scene["bodies"][1]["material"]["density"], 800);
  EXPECT_EQ(scene["bodies"][0]["color"], Json({1, 0, 0}));
  const auto refuse = [&](const std::string& change, const std::vector<std::string>& parts) {
    expect_error(2, {"run", "scene.json", "--set", change}, parts);
  };
  refuse("contact.frction=1",
         {"--set contact.frction=1: contact.frction: found unknown key, expected 'friction'"});
  // An unknown key in the path of a change is an error of the change, not of the file.
  refuse("bodies.box.materil.density=1",
         {"--set bodies.box.materil.density=1: bodies[1].materil: found unknown key, expected 'material'"});
  refuse("contct.budget.kind=1",
         {"--set contct.budget.kind=1: contct: found unknown key, expected 'contact'"});
  refuse("duration=-1", {"--set duration=-1: duration: found -1, expected a number > 0"});
  refuse("bodies.bx.velocity=[0,0,1]", {"--set", "bodies: found 'bx'", "'box'"});
  refuse("bodies[7].name=x", {"bodies: found '7', expected a number below 2"});
  refuse("duration.x=1", {"found 0.1, expected an object that has 'x'"});
  refuse("friction", {"--set: found 'friction', expected KEY=VALUE"});
  refuse("=1", {"--set: found '=1'"});
  refuse("name=", {"--set name=: found an empty value, expected KEY=VALUE, for example contact.friction=0.3; "
                   "an empty text is "});
}

TEST_F(Door, ASceneMayComeFromStandardInput) {
  write("scene.json", falling_box());
  const std::string hash = json_of({"run", "scene.json", "--json", "--no-picture"})["state_hash"];
  EXPECT_NE(shell("palpate run - --json --no-picture --out piped < scene.json 2>/dev/null").find(hash),
            std::string::npos);
  EXPECT_NE(shell("palpate detect - < scene.json 2>/dev/null").find("point,"), std::string::npos);
  EXPECT_EQ(shell("palpate info - < /dev/null 2>&1"),
            "palpate: error: stdin: found nothing, expected a scene file\n");
  EXPECT_TRUE(shell("echo '{\"bodies\": 1}' | palpate run - 2>&1")
                  .starts_with("palpate: error: stdin: bodies: found 1"));
}

TEST_F(Door, HelpOfASubcommandIsAWordToo) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{}, {"run"}, {"generate", "box"}, {"mesh"}}) {
    std::vector<std::string> by_word{"help"};
    by_word.insert(by_word.end(), words.begin(), words.end());
    std::vector<std::string> by_flag = words;
    by_flag.emplace_back("--help");
    EXPECT_EQ(output_of(by_word), output_of(by_flag));
  }
  expect_error(2, {"help", "rnu"}, {"'rnu'", "expected 'run'"});
  expect_error(2, {"help", "run", "extra"},
               {"help: found 'extra', expected no word after 'run', which has no subcommands"});
  expect_error(2, {"help", "generate", "bux"}, {"generate: found unknown subcommand 'bux', expected 'box'"});
  EXPECT_EQ(output_of({"-V"}), output_of({"--version"}));
}

TEST_F(Door, ManualPagesOfAllSubcommandsCanBePrinted) {
  output_of({"manual", "--out", "pages"});
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {}, {"run"}, {"generate"}, {"generate", "box"}, {"bench", "paper"}}) {
    std::string page = "pages/palpate";
    std::vector<std::string> call{"manual"};
    for (const std::string& word : words) page += "-" + word;
    call.insert(call.end(), words.begin(), words.end());
    EXPECT_EQ(output_of(call), read(page + ".1"));
  }
  expect_error(2, {"manual", "rnu"}, {"manual: found 'rnu', expected a subcommand of palpate, or none"});
  expect_error(2, {"manual", "generate", "bux"},
               {"found 'bux', expected a subcommand of palpate generate, or none"});
}

TEST_F(Door, ASceneMayNameItsSchema) {
  const std::string scene = falling_box();
  write("plain.json", scene);
  write("scene.json", R"({"$schema": "https://example.org/scene.schema.json",)" + scene.substr(1));
  const auto hash = [&](const std::string& file) {
    return json_of({"run", file, "--json", "--no-picture"})["state_hash"];
  };
  EXPECT_EQ(hash("scene.json"), hash("plain.json"));
  expect_error(2, {"run", "scene.json", "--set", "$schema=1"}, {"$schema: found 1"});
}

TEST_F(Door, ColoursAreForTerminalsThatShowThem) {
  const auto error_with = [&](const char* name, const char* value) {
    const char* const before = std::getenv(name);
    const std::string kept = before == nullptr ? "" : before;
    ::setenv(name, value, 1);
    const std::string text = palpate_on_terminal({"run", "none.json"}, folder_.path(), 80);
    before == nullptr ? ::unsetenv(name) : ::setenv(name, kept.c_str(), 1);
    return text;
  };
  ::setenv("TERM", "xterm", 0);
  ::unsetenv("NO_COLOR");
  EXPECT_TRUE(error_with("TERM", "xterm")
                  .starts_with("palpate: \x1b[1;31merror:\x1b[0m none.json: found no such file"));
  EXPECT_TRUE(error_with("NO_COLOR", "1").starts_with("palpate: error: none.json"));
  EXPECT_TRUE(error_with("TERM", "dumb").starts_with("palpate: error: none.json"));
}

TEST_F(Door, TheSummaryDoesNotWaitForThePicture) {
  write("scene.json", falling_box());
  const std::string shown = palpate_on_terminal({"run", "scene.json"}, folder_.path(), 80);
  const auto place = [&](const std::string& text) {
    const std::size_t at = shown.find(text);
    EXPECT_NE(at, std::string::npos) << text << " is not in: " << shown;
    return at;
  };
  EXPECT_LT(place("state hash"), place("drawing the picture"));
  EXPECT_LT(place("drawing the picture"), place("picture       results/falling-box/picture.png"));
}

TEST_F(Door, LongNamesAreCutInTables) {
  const std::string name = "left ligamentum teres uteri of the patient";
  write("scene.json", R"({"bodies": [{"name": ")" + name +
                          R"(", "material": {}, "box": {"cells": [1, 1, 1], "size": [0.1, 0.1, 0.1]}}]})");
  const auto lines = lines_of(output_of({"info", "scene.json"}));
  const auto row =
      std::ranges::find_if(lines, [](const std::string& line) { return line.starts_with("left"); });
  ASSERT_NE(row, lines.end());
  EXPECT_TRUE(row->starts_with("left lig... patient ")) << *row;
}

TEST_F(Door, LongNamesAreCutWhereverPeopleReadThem) {
  write(
      "tet.mesh",
      "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n0.1 0 0 0\n0 0.1 0 0\n0 0 0.1 0\n1 1 1 0\n"
      "Tetrahedra\n1\n1 2 3 4 0\nEnd\n");  // a point in no tet draws a note
  const auto scene = [](const std::string& contact) {
    return R"({"name": ")" + std::string(80, 'S') +
           R"(", "time_step": 0.001, "duration": 0.002, "contact": {)" + contact + R"(}, "bodies": [
    {"name": ")" +
           std::string(80, 'H') + R"(", "obstacle": true, "ball": {"radius": 0.1, "resolution": 8}},
    {"name": ")" +
           std::string(80, 'P') + R"(", "material": {}, "mesh": "tet.mesh", "translate": [0, 0, 0.09]}]})";
  };
  write("scene.json", scene(""));
  write("late.json", scene(R"("budget": {"tests": 1})"));
  const auto cut = [](char letter) { return std::string(19, letter) + "..." + std::string(18, letter); };
  const auto expect_cut = [&](const std::vector<std::string>& call, const std::vector<std::string>& parts) {
    const Finished done = palpate(call);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    const std::string text = done.out + done.err;
    for (const std::string& part : parts)
      EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
    for (const char letter : {'S', 'H', 'P'})
      EXPECT_EQ(text.find(std::string(20, letter)), std::string::npos) << text;
  };
  expect_cut({"run", "scene.json", "--no-picture", "--out", "run"},
             {cut('S') + ": 2 steps", "force         " + cut('H'), "in tet 0 of " + cut('P'),
              "note          " + cut('P') + ": 1 point in no tet"});
  expect_cut({"run", "late.json", "--no-picture", "--out", "late"}, {"at the end in " + cut('H')});
  expect_cut({"info", "scene.json"},
             {"scene '" + cut('S') + "'", cut('H') + " and " + cut('P') + ": 12 contacts"});
  expect_cut({"detect", "late.json", "--out", "contacts.csv"},
             {"contacts may be missing in " + cut('H') + ", " + cut('P')});
  EXPECT_EQ(Json::parse(read("run/run.json"))["bodies"][0]["name"], std::string(80, 'H'))
      << "files have all of it";
}

TEST_F(Door, AMissingMeshIsNamedWithItsSceneAndKey) {
  write("scene.json",
        R"({"$schema": "scene.schema.json", "bodies": [{"material": {}, "mesh": "gone.vtu"}]})");
  expect_error(2, {"run", "scene.json"},
               {"scene.json: bodies[0].mesh, gone.vtu: found no such file, expected a "});
}

}  // namespace
}  // namespace palpate::test
