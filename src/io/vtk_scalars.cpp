#include "io/vtk_scalars.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstring>
#include <utility>

namespace palpate::io {
namespace {

using Kind = ScalarType::Kind;

struct NamedType {
  std::string_view name;
  ScalarType type;
};

// vtkXMLDataParser.h and vtkDataReader.cxx; legacy files that hold long or vtkIdType come from 64-bit
// machines.
constexpr std::array<NamedType, 22> named_types{
    {{"Int8", {Kind::integer, 1}},         {"UInt8", {Kind::natural, 1}},
     {"Int16", {Kind::integer, 2}},        {"UInt16", {Kind::natural, 2}},
     {"Int32", {Kind::integer, 4}},        {"UInt32", {Kind::natural, 4}},
     {"Int64", {Kind::integer, 8}},        {"UInt64", {Kind::natural, 8}},
     {"Float32", {Kind::real, 4}},         {"Float64", {Kind::real, 8}},
     {"char", {Kind::integer, 1}},         {"unsigned_char", {Kind::natural, 1}},
     {"short", {Kind::integer, 2}},        {"unsigned_short", {Kind::natural, 2}},
     {"int", {Kind::integer, 4}},          {"unsigned_int", {Kind::natural, 4}},
     {"long", {Kind::integer, 8}},         {"unsigned_long", {Kind::natural, 8}},
     {"vtktypeint64", {Kind::integer, 8}}, {"vtktypeuint64", {Kind::natural, 8}},
     {"float", {Kind::real, 4}},           {"double", {Kind::real, 8}}}};

template <class Number, class Out>
void decode_as(std::string_view bytes, bool swapped, std::vector<Out>& out) {
  out.reserve(bytes.size() / sizeof(Number));
  for (std::size_t i = 0; i + sizeof(Number) <= bytes.size(); i += sizeof(Number)) {
    std::array<char, sizeof(Number)> raw;
    std::memcpy(raw.data(), bytes.data() + i, raw.size());
    if (swapped) std::reverse(raw.begin(), raw.end());
    const auto value = std::bit_cast<Number>(raw);
    if constexpr (std::integral<Out> && std::integral<Number>) {
      out.push_back(std::in_range<Out>(value) ? static_cast<Out>(value) : Out{-1});
    } else {
      out.push_back(static_cast<Out>(value));
    }
  }
}

template <class Out>
void decode_whole(std::string_view bytes, const ScalarType& type, bool swapped, std::vector<Out>& out) {
  const bool natural = type.kind == Kind::natural;
  switch (type.bytes) {
    case 1:
      return natural ? decode_as<std::uint8_t>(bytes, swapped, out)
                     : decode_as<std::int8_t>(bytes, swapped, out);
    case 2:
      return natural ? decode_as<std::uint16_t>(bytes, swapped, out)
                     : decode_as<std::int16_t>(bytes, swapped, out);
    case 4:
      return natural ? decode_as<std::uint32_t>(bytes, swapped, out)
                     : decode_as<std::int32_t>(bytes, swapped, out);
    default:
      return natural ? decode_as<std::uint64_t>(bytes, swapped, out)
                     : decode_as<std::int64_t>(bytes, swapped, out);
  }
}

}  // namespace

const ScalarType* scalar_type(std::string_view name) {
  const auto found = std::find_if(named_types.begin(), named_types.end(),
                                  [&](const NamedType& named) { return named.name == name; });
  return found == named_types.end() ? nullptr : &found->type;
}

std::vector<double> decode_reals(std::string_view bytes, const ScalarType& type, bool swapped) {
  std::vector<double> result;
  if (type.kind != Kind::real) {
    decode_whole(bytes, type, swapped, result);
  } else if (type.bytes == sizeof(float)) {
    decode_as<float>(bytes, swapped, result);
  } else {
    decode_as<double>(bytes, swapped, result);
  }
  return result;
}

std::vector<std::int64_t> decode_integers(std::string_view bytes, const ScalarType& type, bool swapped) {
  std::vector<std::int64_t> result;
  decode_whole(bytes, type, swapped, result);
  return result;
}

}  // namespace palpate::io
