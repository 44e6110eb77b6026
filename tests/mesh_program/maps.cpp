#include "mesh_program/maps.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>

#include "geometry/vector.hpp"

namespace palpate::test {
namespace {

std::string bytes_of(const TestMap& map) {
  return {map.labels.begin(), map.labels.end()};
}

std::string vector_text(const Vec3& v) {
  std::ostringstream text;
  text.precision(17);
  text << '(' << v.x << ',' << v.y << ',' << v.z << ')';
  return text.str();
}

/// Puts a number into bytes, little-endian.
template <class Number, class Bits>
void set(std::string& bytes, std::size_t place, Number value) {
  auto bits = std::bit_cast<Bits>(value);
  for (std::size_t b = 0; b < sizeof(Number); ++b, bits = static_cast<Bits>(bits >> 8U)) {
    bytes[place + b] = static_cast<char>(bits & 0xffU);
  }
}

std::string bytes_of_number(std::uint32_t value, std::size_t count) {
  std::string bytes;
  for (std::size_t b = 0; b < count; ++b, value >>= 8U) bytes.push_back(static_cast<char>(value & 0xffU));
  return bytes;
}

/// The last block of deflated data, not compressed.
std::string stored_block(const std::string& bytes) {
  const auto size = static_cast<std::uint32_t>(bytes.size());
  return "\x01" + bytes_of_number(size, 2) + bytes_of_number(~size, 2) + bytes;
}

/// A data element; text is padded to even length as its kind asks.
std::string element(std::uint32_t group, std::uint32_t tag, const std::string& kind, std::string value) {
  if (value.size() % 2 != 0) value.push_back(kind == "UI" || kind == "OB" ? '\0' : ' ');
  const auto size = static_cast<std::uint32_t>(value.size());
  const std::string length =
      kind == "OB" ? bytes_of_number(0, 2) + bytes_of_number(size, 4) : bytes_of_number(size, 2);
  return bytes_of_number(group, 2) + bytes_of_number(tag, 2) + kind + length + value;
}

std::string number(std::uint32_t group, std::uint32_t tag, int value) {
  return element(group, tag, "US", bytes_of_number(static_cast<std::uint32_t>(value), 2));
}

/// Numbers as DICOM writes them: decimal text of at most 16 letters, a backslash between.
std::string decimals(const std::vector<double>& values) {
  std::ostringstream text;
  text.precision(9);
  for (std::size_t i = 0; i < values.size(); ++i) text << (i == 0 ? "" : "\\") << values[i];
  return text.str();
}

}  // namespace

TestMap::TestMap(std::array<int, 3> voxels, const LabelAt& label) : size(voxels) {
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) labels.push_back(static_cast<std::uint8_t>(label(i, j, k)));
    }
  }
}

std::size_t TestMap::count(int label) const {
  return static_cast<std::size_t>(std::ranges::count(labels, static_cast<std::uint8_t>(label)));
}

double TestMap::volume(int label) const {
  const auto& [a, b, c] = steps;
  const double voxel =
      a.x * (b.y * c.z - b.z * c.y) - a.y * (b.x * c.z - b.z * c.x) + a.z * (b.x * c.y - b.y * c.x);
  return std::abs(voxel) * static_cast<double>(count(label));
}

Vec3 TestMap::place(double i, double j, double k) const {
  const auto along = [&](double Vec3::*c) {
    return origin.*c + steps[0].*c * i + steps[1].*c * j + steps[2].*c * k;
  };
  return {along(&Vec3::x), along(&Vec3::y), along(&Vec3::z)};
}

std::string nrrd(const TestMap& map, const std::string& space, const std::string& more) {
  std::ostringstream header;
  header << "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: " << space << "\nsizes: " << map.size[0]
         << ' ' << map.size[1] << ' ' << map.size[2] << "\nspace directions: " << vector_text(map.steps[0])
         << ' ' << vector_text(map.steps[1]) << ' ' << vector_text(map.steps[2])
         << "\nkinds: domain domain domain\nencoding: raw\nspace origin: " << vector_text(map.origin) << '\n'
         << more << '\n';
  return header.str() + bytes_of(map);
}

std::string nifti(const TestMap& map) {
  constexpr std::size_t header_bytes = 352;
  std::string bytes(header_bytes, '\0');
  const auto int16 = [&](std::size_t place, int value) {
    set<std::int16_t, std::uint16_t>(bytes, place, static_cast<std::int16_t>(value));
  };
  const auto real = [&](std::size_t place, double value) {
    set<float, std::uint32_t>(bytes, place, static_cast<float>(value));
  };
  set<std::int32_t, std::uint32_t>(bytes, 0, 348);
  int16(40, 3);  // dim
  for (std::size_t a = 0; a < 3; ++a) int16(42 + 2 * a, map.size[a]);
  for (std::size_t a = 3; a < 7; ++a) int16(42 + 2 * a, 1);
  int16(70, 2);   // datatype: unsigned char
  int16(72, 8);   // bitpix
  real(76, 1.0);  // pixdim
  for (std::size_t a = 0; a < 3; ++a) real(80 + 4 * a, length(map.steps[a]));
  real(108, header_bytes);  // vox_offset
  real(112, 1.0);           // scl_slope
  bytes[123] = 2;           // xyzt_units: mm
  int16(254, 1);            // sform_code
  const std::array<double Vec3::*, 3> components{&Vec3::x, &Vec3::y, &Vec3::z};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t a = 0; a < 3; ++a) real(280 + 16 * row + 4 * a, map.steps[a].*components[row]);
    real(280 + 16 * row + 12, map.origin.*components[row]);
  }
  bytes.replace(344, 3, "n+1");
  return bytes + bytes_of(map);
}

std::string meta_image(const TestMap& map) {
  std::ostringstream header;
  header.precision(17);
  const auto triple = [&](const Vec3& v) { header << ' ' << v.x << ' ' << v.y << ' ' << v.z; };
  header << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = "
            "False\nCompressedData = False\n"
            "TransformMatrix =";
  for (const Vec3& step : map.steps) {
    const double scale = 1.0 / length(step);
    triple({step.x * scale, step.y * scale, step.z * scale});
  }
  header << "\nOffset =";
  triple(map.origin);
  header << "\nElementSpacing =";
  triple({length(map.steps[0]), length(map.steps[1]), length(map.steps[2])});
  header << "\nDimSize = " << map.size[0] << ' ' << map.size[1] << ' ' << map.size[2]
         << "\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  return header.str() + bytes_of(map);
}

std::string zlib_stored(const std::string& bytes) {
  std::uint32_t a = 1;  // Adler-32
  std::uint32_t b = 0;
  for (const char c : bytes) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  std::string sum = bytes_of_number(a + 65536 * b, 4);
  std::ranges::reverse(sum);
  return "\x78\x01" + stored_block(bytes) + sum;
}

std::string gzip_stored(const std::string& bytes) {
  std::uint32_t sum = 0xffffffffU;  // CRC-32
  for (const char c : bytes) {
    sum ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1U) ^ (sum % 2 == 0 ? 0U : 0xedb88320U);
  }
  const std::string header("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
  return header + stored_block(bytes) + bytes_of_number(~sum, 4) +
         bytes_of_number(static_cast<std::uint32_t>(bytes.size()), 4);
}

std::string dicom_slice(const TestMap& map, int k, const std::string& object_class) {
  const Vec3 corner = map.place(0, 0, k);
  const auto unit = [](const Vec3& v) { return Vec3{v.x / length(v), v.y / length(v), v.z / length(v)}; };
  const Vec3 along = unit(map.steps[0]);
  const Vec3 down = unit(map.steps[1]);
  const std::string root = "1.2.826.0.1.3680043.2.1125.";
  const std::string uid = root + "3." + std::to_string(k + 1);
  const std::string meta = element(2, 0x01, "OB", std::string("\0\1", 2)) +
                           element(2, 0x02, "UI", object_class) + element(2, 0x03, "UI", uid) +
                           element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  const auto slice = static_cast<std::size_t>(map.size[0]) * static_cast<std::size_t>(map.size[1]);
  const auto first = map.labels.begin() + static_cast<std::ptrdiff_t>(slice) * k;
  return std::string(128, '\0') + "DICM" +
         element(2, 0, "UL", bytes_of_number(static_cast<std::uint32_t>(meta.size()), 4)) + meta +
         element(0x08, 0x16, "UI", object_class) + element(0x08, 0x18, "UI", uid) +
         element(0x08, 0x60, "CS", "CT") + element(0x20, 0x0d, "UI", root + "1") +
         element(0x20, 0x0e, "UI", root + "2") + element(0x20, 0x13, "IS", std::to_string(k + 1)) +
         element(0x20, 0x32, "DS", decimals({corner.x, corner.y, corner.z})) +
         element(0x20, 0x37, "DS", decimals({along.x, along.y, along.z, down.x, down.y, down.z})) +
         number(0x28, 0x02, 1) + element(0x28, 0x04, "CS", "MONOCHROME2") + number(0x28, 0x10, map.size[1]) +
         number(0x28, 0x11, map.size[0]) +
         element(0x28, 0x30, "DS", decimals({length(map.steps[1]), length(map.steps[0])})) +
         number(0x28, 0x100, 8) + number(0x28, 0x101, 8) + number(0x28, 0x102, 7) + number(0x28, 0x103, 0) +
         element(0x7fe0, 0x10, "OB", std::string(first, first + static_cast<std::ptrdiff_t>(slice)));
}

std::string segment(int number, int label, const std::string& name, const std::string& color) {
  const std::string key = "Segment" + std::to_string(number) + "_";
  return key + "ID:=Segment_" + std::to_string(number) + '\n' + key + "LabelValue:=" + std::to_string(label) +
         '\n' + key + "Layer:=0\n" + key + "Name:=" + name + '\n' + key + "Color:=" + color + '\n';
}

std::string box_stl(const Vec3& lower, const Vec3& upper, bool open) {
  const auto corner = [&](int c) {
    std::ostringstream text;
    text << "vertex " << (c % 2 == 0 ? lower.x : upper.x) << ' ' << (c / 2 % 2 == 0 ? lower.y : upper.y)
         << ' ' << (c / 4 == 0 ? lower.z : upper.z) << '\n';
    return text.str();
  };
  constexpr std::array<std::array<int, 3>, 12> triangles{{{0, 2, 1},
                                                          {1, 2, 3},
                                                          {4, 5, 6},
                                                          {5, 7, 6},
                                                          {0, 1, 4},
                                                          {1, 5, 4},
                                                          {2, 6, 3},
                                                          {3, 6, 7},
                                                          {0, 4, 2},
                                                          {2, 4, 6},
                                                          {1, 3, 5},
                                                          {3, 7, 5}}};
  std::string text = "solid box\n";
  for (std::size_t t = 0; t < triangles.size() - (open ? 1 : 0); ++t) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int c : triangles[t]) text += corner(c);
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

}  // namespace palpate::test
