#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/types.hpp>

/// Writes values as bytes and reads them back: little-endian, one after the other, without names. For each
/// type a function `serialize(archive, value)` passes the members to the archive; it serves for writing and
/// reading.
namespace palpate {

/// A number, bool or enumerator.
template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class Archive>
void serialize(Archive& archive, Vec3& v) {
  archive(v.x, v.y, v.z);
}

/// The common part of both directions: composite values are handled member by member.
template <class Direction>
class Archive {
 public:
  template <class T, std::size_t n>
  void operator()(std::array<T, n>& values) {
    for (T& value : values) direction()(value);
  }
  template <class T>
  requires(!Scalar<T>) void operator()(T& value) { serialize(direction(), value); }
  template <class First, class Second, class... More>
  void operator()(First& first, Second& second, More&... more) {
    direction()(first);
    direction()(second, more...);
  }

 private:
  Direction& direction() { return static_cast<Direction&>(*this); }
};

/// Appends values to bytes.
class ArchiveWriter : public Archive<ArchiveWriter> {
 public:
  using Archive::operator();
  template <Scalar T>
  void operator()(const T& value) {
    const std::size_t place = bytes_.size();
    bytes_.resize(place + sizeof(T));
    std::memcpy(bytes_.data() + place, &value, sizeof(T));
  }
  void operator()(std::string& text) {
    const std::uint64_t size = text.size();
    (*this)(size);
    const auto bytes = std::as_bytes(std::span(text));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    const std::uint64_t size = values.size();
    (*this)(size);
    for (T& value : values) (*this)(value);
  }
  template <class T>
  void operator()(std::optional<T>& value) {
    (*this)(value.has_value());
    if (value) (*this)(*value);
  }
  /// An enumerator; its number is in [0, count).
  template <class Enum>
  void choice(Enum& value, std::size_t) {
    (*this)(value);
  }

  [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads the bytes of an ArchiveWriter. For any content it stays within the bytes, and allocates at most a
/// small multiple of their number.
class ArchiveReader : public Archive<ArchiveReader> {
 public:
  using Archive::operator();
  /// \param source  name in errors
  ArchiveReader(std::span<const std::byte> bytes, std::string source)
      : bytes_(bytes), source_(std::move(source)) {}

  /// Each overload throws Error if the bytes end too early or hold an invalid value.
  template <Scalar T>
  void operator()(T& value) {
    const std::span<const std::byte> bytes = next(sizeof(T));
    if constexpr (std::same_as<T, bool>) {
      if (bytes[0] > std::byte{1}) fail(std::to_string(static_cast<int>(bytes[0])), "0 or 1");
      value = bytes[0] == std::byte{1};
    } else {
      std::memcpy(&value, bytes.data(), sizeof(T));
    }
  }
  void operator()(std::string& text) {
    const std::span<const std::byte> bytes = next(length());
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    values.clear();
    values.resize(length());
    for (T& value : values) (*this)(value);
  }
  template <class T>
  void operator()(std::optional<T>& value) {
    bool there = false;
    (*this)(there);
    value.reset();
    if (there) (*this)(value.emplace());
  }
  template <class Enum>
  void choice(Enum& value, std::size_t count) {
    std::underlying_type_t<Enum> number{};
    (*this)(number);
    if (number < 0 || static_cast<std::size_t>(number) >= count)
      fail(std::to_string(number), "a number below " + std::to_string(count));
    value = static_cast<Enum>(number);
  }

  /// Throws Error if not all bytes have been read.
  void finish() const {
    if (place_ != bytes_.size()) fail("further bytes", "the end of the data");
  }
  [[noreturn]] void fail(std::string found, std::string expected) const {
    throw Error(source_, "byte " + std::to_string(place_), std::move(found), std::move(expected));
  }

 private:
  /// Reads the number of items of a list. Each item has at least one byte.
  std::size_t length() {
    std::uint64_t count = 0;
    (*this)(count);
    if (count > bytes_.size() - place_)
      fail("a list of " + std::to_string(count) + " items", "a length for which the remaining bytes suffice");
    return static_cast<std::size_t>(count);
  }
  std::span<const std::byte> next(std::size_t size) {
    if (size > bytes_.size() - place_) fail("the end of the data", std::to_string(size) + " more bytes");
    place_ += size;
    return bytes_.subspan(place_ - size, size);
  }

  std::span<const std::byte> bytes_;
  std::string source_;
  std::size_t place_ = 0;
};

/// The kind and the version of sealed bytes.
struct Seal {
  std::string_view kind;  ///< eight characters
  std::uint32_t version;
};

/// Bytes whose integrity can be checked: kind, version, content, and the FNV-1a hash (64 bits) of all bytes
/// before it. A single changed byte always changes the hash; other damage is missed with a probability of
/// 2^-64. It does not protect against manipulation. O(n).
std::vector<std::byte> sealed(const Seal& seal, std::span<const std::byte> content);
/// The content of sealed bytes. Throws Error naming `source` if they have another kind or version, are
/// truncated or were changed. O(n).
std::span<const std::byte> unsealed(const Seal& seal, std::span<const std::byte> bytes,
                                    const std::string& source);

}  // namespace palpate
