#include "io/vtu_arrays.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <span>

#include <palpate/error.hpp>

#include "io/byte_stream.hpp"
#include "io/text_scanner.hpp"
#include "io/uncompress.hpp"

namespace palpate::io {
namespace {

/// Above the compression ratio of all compressors (zlib 1032, LZ4 255, LZMA about 7000): limits the memory
/// that a damaged count can allocate.
constexpr std::uint64_t best_compression = 8192;

/// The bytes of one binary array: VTK's header words, then the data, in blocks if it is compressed
/// (VTK file formats, "XML file formats": "DataArray" and "Compressed data").
class BinaryArray {
 public:
  BinaryArray(const std::string& source, const VtuArray& array, const VtuStructure& structure,
              std::string_view text)
      : source_(source),
        array_(array),
        structure_(structure),
        size_(text.size()),
        stream_(text, array.format == VtuArray::Format::binary || structure.appended_is_base64) {}

  std::string read(std::uint64_t expected_bytes) {
    const bool plain = structure_.compressor == VtuStructure::Compressor::none;
    return plain ? read_plain(expected_bytes) : read_compressed(expected_bytes);
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw Error(source_, "array " + array_.name, found, expected);
  }

  std::string take(std::uint64_t n, const char* what) {
    std::string bytes = stream_.take(n);
    if (bytes.size() == n) return bytes;
    fail(fmt::format("{} bytes and the end of the data", bytes.size()),
         fmt::format("{} bytes ({})", n, what));
  }

  std::uint64_t read_word(const char* what) {
    const std::string bytes = take(structure_.header_bytes, what);
    const ScalarType type{ScalarType::Kind::natural, structure_.header_bytes};
    const std::int64_t word = decode_integers(bytes, type, structure_.swapped).front();
    if (word < 0) fail("a length beyond 63 bits", what);
    return static_cast<std::uint64_t>(word);
  }

  std::string read_plain(std::uint64_t expected_bytes) {
    const std::uint64_t length = read_word("the length of the data");
    if (length != expected_bytes)
      fail(fmt::format("{} bytes", length), fmt::format("{} bytes", expected_bytes));
    return take(length, "the data");
  }

  std::string read_compressed(std::uint64_t expected_bytes) {
    const std::uint64_t blocks = read_word("the number of blocks");
    const std::uint64_t block_bytes = read_word("the length of a block");
    const std::uint64_t last_bytes = read_word("the length of the last block");
    if (blocks > size_ / structure_.header_bytes) {
      fail(fmt::format("{} blocks", blocks), fmt::format("at most {}", size_ / structure_.header_bytes));
    }
    if (expected_bytes / best_compression > size_) {
      fail(fmt::format("{} bytes of compressed data", size_),
           fmt::format("data for {} bytes", expected_bytes));
    }
    std::vector<std::uint64_t> compressed(blocks);
    for (std::uint64_t& length : compressed) length = read_word("the length of a compressed block");
    std::string result(expected_bytes, '\0');
    std::uint64_t done = 0;
    for (std::uint64_t block = 0; block < blocks; ++block) {
      const bool is_partial = block + 1 == blocks && last_bytes != 0;
      const std::uint64_t length = is_partial ? last_bytes : block_bytes;
      if (length > expected_bytes - done) break;
      uncompress(take(compressed[block], "a compressed block"), result.data() + done, length);
      done += length;
    }
    if (done != expected_bytes) fail("blocks that do not add up", fmt::format("{} bytes", expected_bytes));
    return result;
  }

  void uncompress(const std::string& block, char* target, std::uint64_t length) {
    if (length == 0) return;
    if (!can_uncompress(structure_.compressor)) {
      fail("a compressor that this build does not have", "ZLib, or no compression");
    }
    if (!io::uncompress(structure_.compressor, block, std::span(target, length))) {
      fail("a damaged compressed block", fmt::format("{} bytes", length));
    }
  }

  const std::string& source_;
  const VtuArray& array_;
  const VtuStructure& structure_;
  std::size_t size_;
  ByteStream stream_;
};

/// Reads all words of an ASCII array; `take` reads one number, with its name for messages.
template <class Number, class Take>
std::vector<Number> read_ascii(TextScanner& scanner, const VtuArray& array, std::int64_t count, Take take) {
  if (static_cast<std::uint64_t>(count) > scanner.bytes_left()) {
    scanner.fail_end(fmt::format("{} numbers of {}", count, array.name));
  }
  std::vector<Number> values(static_cast<std::size_t>(count));
  for (Number& value : values) {
    if (scanner.at_end()) scanner.fail_end(fmt::format("{} numbers of {}", count, array.name));
    value = take(scanner);
  }
  if (!scanner.at_end()) {
    scanner.word("");
    scanner.fail(fmt::format("only {} numbers of {}", count, array.name));
  }
  return values;
}

}  // namespace

std::string VtuArrays::bytes(const VtuArray& array, std::int64_t count) const {
  std::string_view data = text_.substr(array.begin, array.end - array.begin);
  if (array.format == VtuArray::Format::appended) {
    data = text_.substr(structure_.appended_begin, structure_.appended_end - structure_.appended_begin);
    if (array.offset > data.size()) {
      throw Error(source_, "array " + array.name, fmt::format("offset {}", array.offset),
                  fmt::format("one up to {}, the length of the appended data", data.size()));
    }
    data.remove_prefix(array.offset);
  }
  const auto number_bytes = static_cast<std::uint64_t>(array.type.bytes);
  if (static_cast<std::uint64_t>(count) > std::numeric_limits<std::int64_t>::max() / number_bytes) {
    throw Error(source_, "array " + array.name, fmt::format("{} numbers", count),
                "as many as the file can hold");
  }
  return BinaryArray(source_, array, structure_, data).read(static_cast<std::uint64_t>(count) * number_bytes);
}

std::vector<double> VtuArrays::reals_or_nan(const VtuArray& array, std::int64_t count) const {
  if (array.format == VtuArray::Format::ascii) {
    TextScanner scanner(source_, text_.substr(0, array.end));
    scanner.set_position(array.begin);
    const std::string what = "a number of " + array.name;
    return read_ascii<double>(scanner, array, count, [&](TextScanner& s) { return s.number(what.c_str()); });
  }
  return decode_reals(bytes(array, count), array.type, structure_.swapped);
}

std::vector<double> VtuArrays::reals(const VtuArray& array, std::int64_t count) const {
  std::vector<double> values = reals_or_nan(array, count);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw Error(source_, fmt::format("array {}, number {}", array.name, i), fmt::format("{}", values[i]),
                "a finite number");
  }
  return values;
}

std::vector<std::int64_t> VtuArrays::integers(const VtuArray& array, std::int64_t count) const {
  if (array.type.kind == ScalarType::Kind::real) {
    throw Error(source_, "array " + array.name, "a type with fractions", "a type of whole numbers");
  }
  if (array.format == VtuArray::Format::ascii) {
    TextScanner scanner(source_, text_.substr(0, array.end));
    scanner.set_position(array.begin);
    const std::string what = "a number of " + array.name;
    return read_ascii<std::int64_t>(scanner, array, count,
                                    [&](TextScanner& s) { return s.integer(what.c_str()); });
  }
  return decode_integers(bytes(array, count), array.type, structure_.swapped);
}

}  // namespace palpate::io
