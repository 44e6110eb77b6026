#include "mesh_program/maps.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>

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

double length(const Vec3& v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
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
