// Gives every file of a folder to a fuzzer, without libFuzzer: the committed cases must pass in every build.
//
//   fuzz_NAME FOLDER [CHANGED]
//
// CHANGED: number of damaged copies of each file, always the same ones. A short run for every test, and the
// only one for readers that cannot be built with clang and libFuzzer.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

/// splitmix64 of a counter.
std::size_t random_below(std::uint64_t& counter, std::size_t limit) {
  std::uint64_t z = counter += 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return limit == 0 ? 0 : static_cast<std::size_t>((z ^ (z >> 31U)) % limit);
}

/// A few places changed: a bit, a byte, a digit, a part cut out or doubled, the end cut off.
std::string damaged(std::string bytes, std::uint64_t seed) {
  const std::size_t changes = 1 + random_below(seed, 6);
  for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
    const std::size_t place = random_below(seed, bytes.size());
    const std::size_t length = 1 + random_below(seed, 16);
    switch (random_below(seed, 6)) {
      case 0:
        bytes[place] = static_cast<char>(bytes[place] ^ (1 << random_below(seed, 8)));
        break;
      case 1:
        bytes[place] = static_cast<char>(random_below(seed, 256));
        break;
      case 2:
        bytes[place] = static_cast<char>('0' + random_below(seed, 10));
        break;
      case 3:
        bytes.erase(place, length);
        break;
      case 4:
        bytes.insert(place, bytes.substr(place, length));
        break;
      default:
        bytes.resize(place);
        break;
    }
  }
  return bytes;
}

void give(const std::string& bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::uint64_t changed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  std::uint64_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    std::fprintf(stderr, "%s\n", entry.path().c_str());
    give(bytes);
    for (std::uint64_t i = 0; i < changed; ++i) give(damaged(bytes, i << 20U));
    count += 1 + changed;
  }
  std::fprintf(stderr, "%llu cases\n", static_cast<unsigned long long>(count));
  return count > 0 ? 0 : 1;
}
