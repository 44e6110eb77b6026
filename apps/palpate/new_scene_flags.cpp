#include "new_scene_flags.hpp"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <unistd.h>

#include "exit_codes.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "size_warnings.hpp"

namespace palpate::app {
namespace {

std::string stripped(const std::string& text) {
  constexpr const char* blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

bool keeps_the_guess(const std::string& answer) {
  return answer.empty() || answer == "y" || answer == "Y" || answer == "yes" || answer == "Yes" ||
         answer == "YES";
}

/// Applies an answer of the user to the request: a unit, or a length such as "0.3". Throws BadInput on
/// others.
void apply_answer(const std::string& answer, NewSceneRequest& request) {
  request.unit = mesh_unit(answer);
  if (request.unit) return;
  try {
    request.longest = parse_number("the answer", answer, scene_format::above(0.0));
  } catch (const BadInput&) {
    throw BadInput("the answer", "", "'" + answer + "'",
                   "y, m, cm, mm, um, or the length of the longest side in metres");
  }
}

/// Reads a line from stdin; none at the end of the input.
std::optional<std::string> read_line() {
  std::string line;
  for (int c = std::getchar(); c != '\n'; c = std::getchar()) {
    if (c == EOF) return std::nullopt;
    line += static_cast<char>(c);
  }
  return line;
}

}  // namespace

void add_new_scene_flags(CLI::App& app, NewSceneFlags& flags) {
  CLI::Option* const unit = add_value(app, "--unit", "m|cm|mm|um",
                                      "unit of the coordinates of the mesh; default: guessed from its size",
                                      [&flags](const std::string& flag, const std::string& text) {
                                        flags.request.unit = parse_mesh_unit(flag, text);
                                      });
  add_value(app, "--size", "METRES", "length of the longest side of the mesh, instead of a unit",
            [&flags](const std::string& flag, const std::string& text) {
              flags.request.longest = parse_number(flag, text, scene_format::above(0.0));
            })
      ->excludes(unit);
  app.add_flag("--drop", flags.request.drop,
               "let the body fall onto a floor, instead of fixing its lowest tenth");
  app.add_flag("--yes", flags.yes, "use the guessed unit without asking");
}

void refuse_new_scene_flags(const NewSceneFlags& flags, const std::string& found) {
  const NewSceneRequest& request = flags.request;
  const char* const flag = request.unit      ? "--unit"
                           : request.longest ? "--size"
                           : request.drop    ? "--drop"
                           : flags.yes       ? "--yes"
                                             : nullptr;
  if (flag != nullptr) throw BadInput(flag, "", found, "a mesh of tets");
}

NewScene new_scene_as_agreed(const NewSceneFlags& flags) {
  NewSceneRequest request = flags.request;
  NewScene made = new_scene_of(request);
  if (request.unit || request.longest) return made;
  const bool asks = !flags.yes && ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1;
  if (!asks) {
    print_note(guess_of(made));
    return made;
  }
  const Vec3& size = made.first.size;
  const std::string guess =
      made.unit.name.empty() ? "no unit fits; scaled to" : fmt::format("in {}, this is", made.unit.name);
  print_note(fmt::format(
      "{} is {} long: {} {} and {}. Enter or y: use this; or m, cm, mm, um, or a length in metres:",
      request.mesh.string(), short_text(made.longest_side), guess,
      length_text(std::max({size.x, size.y, size.z})), mass_text(made.first.mass)));
  constexpr int questions = 3;
  for (int asked = 1;; ++asked) {
    const auto line = read_line();
    if (!line) throw BadInput("the answer", "", "the end of the input", "a unit, a length or an empty line");
    const std::string answer = stripped(*line);
    if (keeps_the_guess(answer)) return made;
    try {
      apply_answer(answer, request);
      return new_scene_of(request);
    } catch (const BadInput& refused) {
      if (asked == questions) throw;
      print_note(std::string(refused.what()) + ":");
    }
  }
}

}  // namespace palpate::app
