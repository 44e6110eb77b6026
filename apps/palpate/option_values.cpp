#include "option_values.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <system_error>
#include <utility>

#include "exit_codes.hpp"
#include "scene/suggest.hpp"

namespace palpate::app {
namespace {

std::string quoted(const std::string& text) {
  return "'" + text + "'";
}

/// Parses a number; all of `text` must belong to it.
template <class Number>
std::optional<Number> whole_number(std::string_view text) {
  Number value{};
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

}  // namespace

std::int64_t parse_integer(const std::string& flag, const std::string& text, std::int64_t low,
                           std::int64_t high) {
  const auto value = whole_number<std::int64_t>(text);
  if (!value || *value < low || *value > high) {
    const bool is_digits = text.find_first_not_of("0123456789") == std::string::npos;
    const bool open = high >= std::numeric_limits<int>::max() && (value || !is_digits);
    throw BadInput(
        flag, "", quoted(text),
        open ? fmt::format("an integer >= {}", low) : fmt::format("an integer in [{}, {}]", low, high));
  }
  return *value;
}

double parse_number(const std::string& flag, const std::string& text, const scene_format::Limits& limits) {
  const auto value = whole_number<double>(text);
  if (!value || !std::isfinite(*value) || !limits.allow(*value)) {
    throw BadInput(flag, "", quoted(text), scene_format::expected_within(limits, "a number"));
  }
  return *value;
}

std::size_t parse_choice(const std::string& flag, const std::string& text,
                         std::span<const std::string_view> names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == text) return i;
  }
  constexpr std::size_t few = 3;  // all are named
  throw BadInput(flag, "", quoted(text), expected_name(names.size() <= few ? "" : text, names));
}

MeshUnit parse_mesh_unit(const std::string& flag, const std::string& text) {
  const std::optional<MeshUnit> unit = mesh_unit(text);
  if (!unit) throw BadInput(flag, "", quoted(text), "one of 'm', 'cm', 'mm', 'um'");
  return *unit;
}

CLI::Option* add_value(CLI::App& app, const std::string& flag, const std::string& type,
                       const std::string& help,
                       std::function<void(const std::string&, const std::string&)> parse) {
  const auto given = [flag, parse = std::move(parse)](const std::string& text) {
    if (text.empty()) throw BadInput(flag, "", "''", "a value");
    parse(flag, text);
  };
  return app.add_option_function<std::string>(flag, given, help)->type_name(type)->take_last();
}

CLI::Option* add_path(CLI::App& app, const std::string& name, std::filesystem::path& path,
                      const std::string& help) {
  const auto given = [&path](const std::string& text) { path = text; };
  return app.add_option_function<std::string>(name, given, help)->type_name("")->required();
}

CLI::Option* add_repeated(CLI::App& app, const std::string& flag, const std::string& type,
                          const std::string& help,
                          std::function<void(const std::string&, const std::string&)> given) {
  const auto all = [flag, given = std::move(given)](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) given(flag, text);
  };
  return app.add_option_function<std::vector<std::string>>(flag, all, help)
      ->type_name(type)
      ->allow_extra_args(false);
}

CLI::Option* add_changes(CLI::App& app, std::vector<std::string>& changes) {
  return add_repeated(app, "--set", "KEY=VALUE",
                      "sets a value of the scene, such as contact.friction=0.3 or "
                      "bodies.liver.material.density=1060; may be repeated",
                      [&changes](const std::string&, const std::string& text) { changes.push_back(text); });
}

void add_threads(CLI::App& app, int& threads) {
  add_value(app, "--threads", "N",
            "number of threads; 0, the default: all of the machine. Results do not depend on it",
            [&threads](const std::string& flag, const std::string& text) {
              constexpr int most = 1024;
              threads = static_cast<int>(parse_integer(flag, text, 0, most));
            });
}

void add_json(CLI::App& app, bool& json, const std::string& help) {
  app.add_flag("--json", json, help);
}

void add_triple(CLI::App& app, const std::string& flag, const std::string& type, const std::string& help,
                std::array<int, 3>& values) {
  const auto given = [flag, &values](const std::vector<std::string>& texts) {
    constexpr int most = 1024;
    for (std::size_t i = 0; i < 3; ++i) values[i] = static_cast<int>(parse_integer(flag, texts[i], 1, most));
  };
  app.add_option_function<std::vector<std::string>>(flag, given, help)
      ->type_name(type)
      ->type_size(3)
      ->expected(1);
}

void add_triple(CLI::App& app, const std::string& flag, const std::string& type, const std::string& help,
                Vec3& values) {
  const auto given = [flag, &values](const std::vector<std::string>& texts) {
    const auto number = [&](std::size_t i) { return parse_number(flag, texts[i], scene_format::above(0.0)); };
    values = {number(0), number(1), number(2)};
  };
  app.add_option_function<std::vector<std::string>>(flag, given, help)
      ->type_name(type)
      ->type_size(3)
      ->expected(1);
}

}  // namespace palpate::app
