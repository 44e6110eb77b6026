#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <palpate/error.hpp>

#include "io/text_scanner.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

enum class Encoding : std::uint8_t { text, little, big };

enum class Kind : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
struct KindName {
  std::string_view name;
  Kind kind;
};
constexpr std::array<KindName, 16> kind_names{{{"char", Kind::int8},
                                               {"int8", Kind::int8},
                                               {"uchar", Kind::uint8},
                                               {"uint8", Kind::uint8},
                                               {"short", Kind::int16},
                                               {"int16", Kind::int16},
                                               {"ushort", Kind::uint16},
                                               {"uint16", Kind::uint16},
                                               {"int", Kind::int32},
                                               {"int32", Kind::int32},
                                               {"uint", Kind::uint32},
                                               {"uint32", Kind::uint32},
                                               {"float", Kind::float32},
                                               {"float32", Kind::float32},
                                               {"double", Kind::float64},
                                               {"float64", Kind::float64}}};
constexpr std::array<std::size_t, 8> bytes_of_kind{1, 1, 2, 2, 4, 4, 4, 8};

struct Property {
  std::string name;
  Kind kind{};
  std::optional<Kind> length;  ///< type of the length of a list; none: a single number
};
struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

Kind take_kind(io::TextScanner& header) {
  const std::string_view word = header.word("a type of numbers");
  const auto* found = std::ranges::find(kind_names, word, &KindName::name);
  if (found == kind_names.end()) header.fail("a type of numbers (char, uchar, short, ..., double)");
  return found->kind;
}

Encoding take_encoding(io::TextScanner& header) {
  const std::string_view word = header.word("the format");
  if (word == "ascii") return Encoding::text;
  if (word == "binary_little_endian") return Encoding::little;
  if (word != "binary_big_endian") header.fail("ascii, binary_little_endian or binary_big_endian");
  return Encoding::big;
}

/// Reads the header, up to the first byte behind it.
std::vector<Element> take_header(io::TextScanner& header, Encoding& encoding) {
  header.keyword("ply");
  header.keyword("format");
  encoding = take_encoding(header);
  header.skip_line();
  std::vector<Element> elements;
  for (;;) {
    const std::string_view word = header.word("end_header");
    if (word == "end_header") break;
    if (word == "element") {
      Element& element = elements.emplace_back();
      element.name = header.word("the name of an element");
      element.count = header.integer("a number of elements", 0, std::numeric_limits<Index>::max());
    } else if (word == "property") {
      if (elements.empty()) header.fail("an element before its properties");
      Property& property = elements.back().properties.emplace_back();
      if (header.peek() == "list") {
        header.keyword("list");
        property.length = take_kind(header);
      }
      property.kind = take_kind(header);
      property.name = header.word("the name of a property");
    } else if (word != "comment" && word != "obj_info") {
      header.fail("element, property, comment or end_header");
    }
    header.skip_line();
  }
  header.skip_line();
  return elements;
}

/// Reads the numbers behind the header one after the other.
class Numbers {
 public:
  Numbers(io::TextScanner& text, Encoding encoding) : text_(text), encoding_(encoding) {}

  double take(Kind kind) {
    if (encoding_ == Encoding::text) return text_.number("a number");
    const std::size_t size = bytes_of_kind[static_cast<std::size_t>(kind)];
    if (text_.bytes_left() < size) fail("the end of the file", "a number");
    std::array<char, 8> bytes{};
    std::copy_n(text_.text().begin() + static_cast<std::ptrdiff_t>(text_.position()), size, bytes.begin());
    text_.set_position(text_.position() + size);
    const bool is_little = std::endian::native == std::endian::little;
    if ((encoding_ == Encoding::little) != is_little)
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    return value_of(kind, bytes);
  }
  /// Reads an integer in [0, end).
  Index index(Kind kind, std::int64_t end, const char* what) {
    const double value = take(kind);
    if (value >= 0.0 && value < static_cast<double>(end) && value == std::floor(value))
      return static_cast<Index>(value);
    fail(fmt::format("{}", value), fmt::format("{} from 0 to {}", what, end - 1));
  }
  /// The largest count of further numbers that the rest of the file can hold.
  [[nodiscard]] std::int64_t most(Kind kind) const {
    const std::size_t each = encoding_ == Encoding::text ? 1 : bytes_of_kind[static_cast<std::size_t>(kind)];
    return static_cast<std::int64_t>(
        std::min<std::size_t>(text_.bytes_left() / each, std::numeric_limits<Index>::max() - 1));
  }
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    if (encoding_ == Encoding::text) text_.fail(found, expected);
    throw Error(text_.source(), fmt::format("byte {}", text_.position()), found, expected);
  }

 private:
  template <class Number>
  static double as(const std::array<char, 8>& bytes) {
    Number number{};
    std::memcpy(&number, bytes.data(), sizeof(number));
    return static_cast<double>(number);
  }
  static double value_of(Kind kind, const std::array<char, 8>& bytes) {
    switch (kind) {
      case Kind::int8:
        return as<std::int8_t>(bytes);
      case Kind::uint8:
        return as<std::uint8_t>(bytes);
      case Kind::int16:
        return as<std::int16_t>(bytes);
      case Kind::uint16:
        return as<std::uint16_t>(bytes);
      case Kind::int32:
        return as<std::int32_t>(bytes);
      case Kind::uint32:
        return as<std::uint32_t>(bytes);
      case Kind::float32:
        return as<float>(bytes);
      case Kind::float64:
        break;
    }
    return as<double>(bytes);
  }

  io::TextScanner& text_;
  Encoding encoding_;
};

double* coordinate(Vec3& point, std::string_view name) {
  if (name == "x") return &point.x;
  if (name == "y") return &point.y;
  return name == "z" ? &point.z : nullptr;
}

void require_coordinates(const Element& element, const std::string& source) {
  for (const char* name : {"x", "y", "z"}) {
    const auto is_it = [&](const Property& property) { return property.name == name && !property.length; };
    if (std::ranges::count_if(element.properties, is_it) != 1)
      throw Error(source, "element vertex", fmt::format("not one number {}", name), "x, y and z");
  }
}

/// Reads one element: its properties in their order.
void take_element(Numbers& numbers, const Element& element, std::int64_t vertices, PolygonFile& file) {
  const bool is_vertex = element.name == "vertex";
  const bool is_face = element.name == "face";
  Vec3 point;
  for (const Property& property : element.properties) {
    if (!property.length) {
      const double value = numbers.take(property.kind);
      double* const place = is_vertex ? coordinate(point, property.name) : nullptr;
      if (place == nullptr) continue;
      if (!std::isfinite(value)) numbers.fail(fmt::format("{}", value), "a finite number");
      *place = value;
      continue;
    }
    const Index length =
        numbers.index(*property.length, numbers.most(property.kind) + 1, "a length of a list");
    if (is_face && (property.name == "vertex_indices" || property.name == "vertex_index")) {
      std::vector<Index>& polygon = file.polygons.emplace_back();
      for (Index i = 0; i < length; ++i) polygon.push_back(numbers.index(property.kind, vertices, "a point"));
    } else {
      for (Index i = 0; i < length; ++i) numbers.take(property.kind);
    }
  }
  if (is_vertex) file.points.push_back(point);
}

}  // namespace

PolygonFile read_ply(const std::string& source, std::string_view bytes) {
  io::TextScanner text(source, bytes);
  Encoding encoding{};
  const std::vector<Element> elements = take_header(text, encoding);
  if (std::ranges::count(elements, "vertex", &Element::name) != 1) {
    throw Error(source, "header", "no element vertex, or more than one",
                "one element vertex, with x, y and z");
  }
  const Element& vertex = *std::ranges::find(elements, "vertex", &Element::name);
  require_coordinates(vertex, source);
  Numbers numbers(text, encoding);
  PolygonFile file;
  for (const Element& element : elements) {
    if (element.properties.empty()) continue;
    for (std::int64_t i = 0; i < element.count; ++i) take_element(numbers, element, vertex.count, file);
  }
  return file;
}

}  // namespace palpate::app
