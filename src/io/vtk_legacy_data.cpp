#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include <palpate/error.hpp>

#include "io/text_scanner.hpp"
#include "io/vtk_legacy_file.hpp"
#include "io/vtk_legacy_numbers.hpp"

namespace palpate::io {
namespace {

/// Decodes the name of an array: blanks and special characters are written as %20.
std::string decoded(std::string_view word) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string name;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const std::size_t high = i + 2 < word.size() ? digits.find(word[i + 1]) : digits.npos;
    const std::size_t low = i + 2 < word.size() ? digits.find(word[i + 2]) : digits.npos;
    const bool escaped = word[i] == '%' && high != digits.npos && low != digits.npos;
    name.push_back(escaped ? static_cast<char>(16 * high + low) : word[i]);
    if (escaped) i += 2;
  }
  return name;
}

/// Skips the point and cell data of a file up to a wanted array, and reads that (VTK file formats, "Dataset
/// attributes").
class LegacyDataReader {
 public:
  LegacyDataReader(TextScanner& scanner, const VtkLegacyFile& file, const CellDataKey& key)
      : scanner_(scanner), numbers_(scanner), cells_(file.cells.ends.size()), key_(key) {
    numbers_.set_binary(file.binary);
    scanner_.set_position(file.data_begin);
  }

  std::vector<double> read() {
    while (!found_ && !scanner_.at_end()) read_section();
    if (!found_) throw Error(scanner_.source(), "", "no cell data of the name '" + key_.name + "'", "some");
    const auto bad = std::ranges::find_if_not(values_, [](double value) { return std::isfinite(value); });
    if (bad != values_.end()) {
      const auto cell = static_cast<std::size_t>(bad - values_.begin()) / key_.components;
      throw Error(scanner_.source(), fmt::format("cell data {}, cell {}", key_.name, cell),
                  fmt::format("{}", *bad), "finite numbers");
    }
    return std::move(values_);
  }

 private:
  void read_section() {
    if (upper_case(scanner_.peek()) == "METADATA") return numbers_.skip_metadata();
    const std::string kind = upper_case(scanner_.word(""));
    if (kind == "POINT_DATA" || kind == "CELL_DATA") {
      of_cells_ = kind == "CELL_DATA";
      rows_ = count_of("the number of points or cells");
      if (of_cells_ && rows_ != cells_)
        scanner_.fail(fmt::format("{} rows of cell data", rows_), fmt::format("{}, one a cell", cells_));
      return;
    }
    if (kind == "FIELD") return read_field();
    const std::string name = decoded(scanner_.word("the name of an array"));
    if (kind == "VECTORS" || kind == "NORMALS") {
      take(name, 3, rows_, numbers_.read_type());
    } else if (kind == "TENSORS") {
      take(name, 9, rows_, numbers_.read_type());
    } else if (kind == "GLOBAL_IDS" || kind == "PEDIGREE_IDS") {
      take(name, 1, rows_, numbers_.read_type());
    } else if (kind == "TEXTURE_COORDINATES") {
      const std::size_t components = count_of("the number of components");
      take(name, components, rows_, numbers_.read_type());
    } else if (kind == "SCALARS") {
      read_scalars(name);
    } else if (kind == "COLOR_SCALARS") {
      take(name, count_of("the number of components"), rows_, colours());
    } else if (kind == "LOOKUP_TABLE") {
      take(name, 4, count_of("the number of colours"), colours());
    } else {
      scanner_.fail("data such as VECTORS or FIELD");
    }
  }

  std::size_t count_of(const char* what) {
    return static_cast<std::size_t>(scanner_.integer(what, 0, std::numeric_limits<Index>::max()));
  }
  /// In ASCII files, colours are numbers from 0 to 1.
  static const ScalarType& colours() { return *scalar_type("unsigned_char"); }

  /// The number of components is often omitted.
  void read_scalars(const std::string& name) {
    const ScalarType& type = numbers_.read_type();
    const std::size_t components = scanner_.at_line_end() ? 1 : count_of("the number of components");
    if (upper_case(scanner_.peek()) == "LOOKUP_TABLE") {
      scanner_.word("");
      scanner_.word("the name of a table");
    }
    take(name, components, rows_, type);
  }

  void read_field() {
    scanner_.word("the name of a field");
    const Index arrays = scanner_.count("the number of arrays", 8);
    for (Index array = 0; array < arrays && !found_; ++array) {
      const std::string name = decoded(scanner_.word("the name of an array"));
      const std::size_t components = count_of("the number of components");
      const std::size_t rows = count_of("the number of rows");
      take(name, components, rows, numbers_.read_type());
      numbers_.skip_metadata();
    }
  }

  void take(const std::string& name, std::size_t components, std::size_t rows, const ScalarType& type) {
    if (!of_cells_ || name != key_.name) return numbers_.skip(components * rows, type);
    if (components != key_.components || rows != cells_) {
      throw Error(scanner_.source(), "cell data " + key_.name,
                  fmt::format("{} components in {} rows", components, rows),
                  fmt::format("{}, {} rows", key_.expected(), cells_));
    }
    values_ = numbers_.reals(components * rows, type, "a component of cell data");
    found_ = true;
  }

  TextScanner& scanner_;
  LegacyNumbers numbers_;
  std::size_t cells_;
  const CellDataKey& key_;
  bool of_cells_ = false;
  bool found_ = false;
  std::size_t rows_ = 0;
  std::vector<double> values_;
};

}  // namespace

std::vector<double> read_vtk_legacy_data(const std::string& source, std::string_view bytes,
                                         const VtkLegacyFile& file, const CellDataKey& key) {
  TextScanner scanner(source, bytes);
  return LegacyDataReader(scanner, file, key).read();
}

}  // namespace palpate::io
