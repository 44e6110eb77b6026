#include <algorithm>
#include <utility>

#include <palpate/error.hpp>

namespace palpate {
namespace {

std::string one_line(const std::string& source, const std::string& where, const std::string& found,
                     const std::string& expected) {
  std::string line = source;
  if (!where.empty()) line += ": " + where;
  line += ": found " + found + ", expected " + expected;
  std::ranges::replace(line, '\0', '?');  // or what() ends there
  return line;
}

}  // namespace

Error::Error(std::string source, std::string where, std::string found, std::string expected)
    : std::runtime_error(one_line(source, where, found, expected)),
      source_(std::move(source)),
      where_(std::move(where)),
      found_(std::move(found)),
      expected_(std::move(expected)) {}

}  // namespace palpate
