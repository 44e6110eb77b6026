#include <palpate/version.hpp>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Usage : public CommandTest {};

TEST_F(Usage, HelpOfEverySubcommandTeachesByExamples) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{},
                                                                                     {"run"},
                                                                                     {"info"},
                                                                                     {"detect"},
                                                                                     {"new"},
                                                                                     {"completion"},
                                                                                     {"manual"},
                                                                                     {"generate"},
                                                                                     {"generate", "stacking"},
                                                                                     {"generate", "box"},
                                                                                     {"generate", "ball"}}) {
    std::vector<std::string> arguments = words;
    arguments.emplace_back("--help");
    const std::string help = output_of(arguments);
    std::string call = "  palpate";
    for (const std::string& word : words) call += " " + word;
    EXPECT_NE(help.find("Usage: " + call.substr(2)), std::string::npos) << help;
    EXPECT_NE(help.find("Examples:"), std::string::npos) << help;
    const std::size_t first = help.find(call, help.find("Examples:"));
    EXPECT_NE(first, std::string::npos) << help;
    EXPECT_NE(help.find(call, first + 1), std::string::npos) << "a second example is missing: " << help;
  }
}

TEST_F(Usage, VersionIsThatOfTheLibrary) {
  EXPECT_TRUE(output_of({"--version"}).starts_with("palpate " PALPATE_VERSION " ("));
}

TEST_F(Usage, UnknownSubcommandsNameTheNearest) {
  expect_error(2, {"rnu", "scene.json"}, {"'rnu'", "expected 'run'"});
  expect_error(2, {"generate", "stackin"}, {"'stackin'", "expected 'stacking'"});
  expect_error(2, {"xyzzy"},
               {"'xyzzy'",
                "one of 'new', 'view', 'run', 'info', 'detect', 'generate', 'bench', 'completion', 'manual', "
                "'mesh', 'help'"});
}

TEST_F(Usage, MissingSubcommandsAndArgumentsAreNamed) {
  expect_error(2, {}, {"no subcommand", "'run'"});
  expect_error(2, {"generate"}, {"no subcommand", "'stacking'", "'box'", "'ball'"});
  expect_error(2, {"run"}, {"SCENE is required"});
  expect_error(2, {"detect"}, {"SCENE is required"});
  expect_error(2, {"info"}, {"FILE is required"});
  expect_error(2, {"run", "scene.json", "--steps"}, {"--steps: found no value, expected N"});
  expect_error(2, {"generate", "box", "--cells", "1", "2"},
               {"--cells: found too few values, expected NX NY NZ"});
}

TEST_F(Usage, FlagsBeforeTheirSubcommandAreSaidToBeThere) {
  expect_error(2, {"--json", "info", "mesh.vtu"},
               {"info: found '--json' before the subcommand, expected '--json' behind it"});
  expect_error(2, {"--jsno", "info", "mesh.vtu"}, {"unknown flag '--jsno', expected '--json'"});
}

TEST_F(Usage, ShortListsAreNamedWhole) {
  expect_error(2, {"completion", "csh"}, {"completion: found 'csh', expected one of 'bash', 'zsh', 'fish'"});
}

TEST_F(Usage, IntegersThatAreTooLargeNameTheirRange) {
  expect_error(2, {"run", "scene.json", "--steps", "99999999999999999999"},
               {"expected an integer in [0, 9223372036854775807]"});
  write("scene.json", falling_box());
  expect_error(2, {"run", "scene.json", "--set", "output.every=1e30"},
               {"output.every", "expected an integer in [1, 2147483647]"});
}

TEST_F(Usage, UnknownFlagsNameTheNearest) {
  expect_error(2, {"run", "scene.json", "--stepz", "5"}, {"run:", "'--stepz'", "expected '--steps'"});
  expect_error(2, {"run", "--until-rst"}, {"'--until-rst'", "expected '--until-rest'"});
  expect_error(2, {"info", "--jason", "x.msh"}, {"info:", "'--jason'", "expected '--json'"});
  expect_error(2, {"generate", "box", "--sizes", "1", "1", "1"}, {"generate box:", "expected '--size'"});
  expect_error(2, {"--versoin"}, {"'--versoin'", "expected '--version'"});
  expect_error(2, {"detect", "s.json", "--fromat=csv"}, {"'--fromat'", "expected '--format'"});
  expect_error(2, {"run", "a.json", "b.json"}, {"run:", "'b.json'"});
}

TEST_F(Usage, BadValuesSayWhatIsExpected) {
  const auto refuse = [&](const std::string& flag, const std::string& value, const std::string& expected) {
    expect_error(2, {"run", "scene.json", flag, value}, {flag, "'" + value + "'", expected});
  };
  refuse("--steps", "abc", "an integer >= 0");
  refuse("--steps", "-1", "an integer >= 0");
  refuse("--steps", "3.5", "an integer >= 0");
  refuse("--out", "", "a value");
  refuse("--every", "0", "an integer >= 1");
  refuse("--threads", "-2", "an integer in [0, 1024]");
  refuse("--threads", "two", "an integer in [0, 1024]");
  refuse("--cell-size", "0", "'auto', 'mean-edge', 'max-edge' or a number > 0");
  refuse("--cell-size", "nan", "'auto', 'mean-edge', 'max-edge' or a number > 0");
  refuse("--cell-size", "mean", "'auto', 'mean-edge', 'max-edge' or a number > 0");
  refuse("--structure", "compat", "'compact'");
  refuse("--order", "liner", "'linear'");
  refuse("--sort", "raddix", "'radix'");
  expect_error(2, {"detect", "scene.json", "--format", "cvs"}, {"--format", "'cvs'", "'csv'"});
  expect_error(2, {"generate", "box", "--size", "1", "0", "1"}, {"--size", "'0'", "a number > 0"});
  expect_error(2, {"generate", "box", "--cells", "1", "1.5", "1"}, {"--cells", "'1.5'", "an integer"});
  expect_error(2, {"generate", "ball", "--radius", "-1"}, {"--radius", "'-1'", "a number > 0"});
  expect_error(2, {"generate", "stacking", "--count", "0"}, {"--count", "'0'", "an integer in [1, 100000]"});
}

TEST_F(Usage, TheLastOfTwoValuesCounts) {
  write("scene.json", falling_box());
  EXPECT_EQ(json_of({"run", "scene.json", "--steps", "7", "--steps", "2", "--json", "--no-picture"})["steps"],
            2);
}

}  // namespace
}  // namespace palpate::test
