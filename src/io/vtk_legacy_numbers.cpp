#include "io/vtk_legacy_numbers.hpp"

#include <bit>
#include <cctype>
#include <fmt/format.h>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

constexpr bool swapped = std::endian::native == std::endian::little;  // legacy files are big-endian

}  // namespace

const ScalarType& LegacyNumbers::read_type() {
  std::string name(scanner_.word("a type of numbers"));
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  // Files of version 5 say vtktypeint64 where they mean 64 bits; vtkIdType itself is always written as int.
  const ScalarType* type = scalar_type(name == "vtkidtype" ? "int" : name);
  if (type == nullptr) scanner_.fail("a type of numbers such as float or int");
  return *type;
}

std::string_view LegacyNumbers::read_bytes(std::size_t count, std::size_t bytes_each) {
  if (!scanner_.at_line_end()) {
    scanner_.word("");
    scanner_.fail("the end of the line");
  }
  scanner_.skip_line();
  if (count > scanner_.bytes_left() / bytes_each) {
    throw Error(scanner_.source(), fmt::format("byte {}", scanner_.position()),
                fmt::format("{} bytes and the end of the file", scanner_.bytes_left()),
                fmt::format("{} numbers of {} bytes", count, bytes_each));
  }
  const std::string_view bytes = scanner_.text().substr(scanner_.position(), count * bytes_each);
  scanner_.set_position(scanner_.position() + bytes.size());
  return bytes;
}

std::vector<double> LegacyNumbers::reals(std::size_t count, const ScalarType& type, const char* what) {
  if (binary_) return decode_reals(read_bytes(count, type.bytes), type, swapped);
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(scanner_.number(what));
  return values;
}

std::vector<std::int64_t> LegacyNumbers::integers(std::size_t count, const ScalarType& type,
                                                  const char* what) {
  if (type.kind == ScalarType::Kind::real) scanner_.fail("a type of whole numbers");
  if (binary_) return decode_integers(read_bytes(count, type.bytes), type, swapped);
  std::vector<std::int64_t> values(count);
  for (std::int64_t& value : values) value = scanner_.integer(what);
  return values;
}

void LegacyNumbers::skip(std::size_t count, const ScalarType& type) {
  if (binary_) {
    read_bytes(count, type.bytes);
  } else {
    for (std::size_t i = 0; i < count; ++i) scanner_.number("a number of an array");
  }
}

void LegacyNumbers::skip_metadata() {
  if (upper_case(scanner_.peek()) != "METADATA") return;
  scanner_.skip_line();
  while (scanner_.bytes_left() > 0 && !scanner_.at_line_end()) scanner_.skip_line();
}

std::string upper_case(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

}  // namespace palpate::io
