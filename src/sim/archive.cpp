#include "sim/archive.hpp"

#include "sim/state_hash.hpp"

namespace palpate {
namespace {

constexpr std::size_t head_size = 8 + sizeof(std::uint32_t);
constexpr std::size_t hash_size = sizeof(std::uint64_t);

template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t place) {
  T number{};
  std::memcpy(&number, bytes.data() + place, sizeof(T));
  return number;
}

}  // namespace

std::vector<std::byte> sealed(const Seal& seal, std::span<const std::byte> content) {
  const auto kind = std::as_bytes(std::span(seal.kind));
  const auto version = std::as_bytes(std::span(&seal.version, 1));
  std::vector<std::byte> bytes;
  bytes.reserve(head_size + content.size() + hash_size);
  bytes.insert(bytes.end(), kind.begin(), kind.end());
  bytes.insert(bytes.end(), version.begin(), version.end());
  bytes.insert(bytes.end(), content.begin(), content.end());
  const std::uint64_t hash = fnv1a(bytes);
  const auto end = std::as_bytes(std::span(&hash, 1));
  bytes.insert(bytes.end(), end.begin(), end.end());
  return bytes;
}

std::span<const std::byte> unsealed(const Seal& seal, std::span<const std::byte> bytes,
                                    const std::string& source) {
  const std::string kind(seal.kind);
  if (bytes.size() < head_size + hash_size || std::memcmp(bytes.data(), kind.data(), kind.size()) != 0)
    throw Error(source, "", "a file of another kind", "a '" + kind + "' file");
  const auto without_hash = bytes.first(bytes.size() - hash_size);
  if (fnv1a(without_hash) != number_at<std::uint64_t>(bytes, without_hash.size())) {
    throw Error(source, "", "a wrong checksum: the file is cut off or was changed",
                "the file as it was written");
  }
  const auto version = number_at<std::uint32_t>(bytes, kind.size());
  if (version != seal.version) {
    throw Error(source, "", "version " + std::to_string(version),
                "version " + std::to_string(seal.version) + ", the one that this build reads");
  }
  return without_hash.subspan(head_size);
}

}  // namespace palpate
