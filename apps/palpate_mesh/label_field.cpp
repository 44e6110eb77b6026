#include <algorithm>
#include <cmath>
#include <itkDiscreteGaussianImageFilter.h>
#include <itkImage.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <numbers>

#include "organ.hpp"

namespace palpate::app {
namespace {

using Image = itk::Image<float, 3>;
using Mask = itk::Image<std::uint8_t, 3>;

/// The voxels around a label that its field needs; they may extend beyond the map.
struct Crop {
  std::array<int, 3> lower{};
  std::array<int, 3> size{};
};

Crop crop_of(const LabelExtent& extent, const LabelMap& map, const Shaping& shaping) {
  constexpr double widths = 4.0;  // in standard deviations of the blur; beyond, it is zero
  const double least = std::min({map.spacing.x, map.spacing.y, map.spacing.z});
  const int margin = 2 + static_cast<int>(std::ceil(widths * shaping.smoothing + shaping.gap / least));
  Crop crop;
  for (std::size_t a = 0; a < 3; ++a) {
    crop.lower[a] = extent.box.lower[a] - margin;
    crop.size[a] = extent.box.upper[a] - extent.box.lower[a] + 1 + 2 * margin;
  }
  return crop;
}

/// An image of the crop: 1 where `is_in(label)` is true; 0 elsewhere and beyond the map.
template <class Picture, class Function>
typename Picture::Pointer mask_of(const LabelMap& map, const Crop& crop, Function&& is_in) {
  typename Picture::SizeType size;
  for (unsigned a = 0; a < 3; ++a) size[a] = static_cast<itk::SizeValueType>(crop.size[a]);
  const auto image = Picture::New();
  image->SetRegions(typename Picture::RegionType(size));
  const std::array<double, 3> spacing{map.spacing.x, map.spacing.y, map.spacing.z};
  image->SetSpacing(spacing.data());
  image->Allocate();
  auto* value = image->GetBufferPointer();
  for_points(crop.size, [&](int i, int j, int k) {
    const std::array<int, 3> voxel{crop.lower[0] + i, crop.lower[1] + j, crop.lower[2] + k};
    bool is_there = true;
    for (std::size_t a = 0; a < 3; ++a) is_there = is_there && voxel[a] >= 0 && voxel[a] < map.size[a];
    *value++ = is_there && is_in(map.at(voxel[0], voxel[1], voxel[2])) ? 1 : 0;
  });
  return image;
}

Image::Pointer blurred(const Image::Pointer& image, double smoothing) {
  if (smoothing <= 0.0) return image;
  const auto filter = itk::DiscreteGaussianImageFilter<Image, Image>::New();
  filter->SetInput(image);
  filter->SetUseImageSpacing(
      false);  // in voxels: it removes the staircase of voxels, which has their proportions
  filter->SetVariance(smoothing * smoothing);
  filter->SetMaximumError(1e-3);
  filter->SetMaximumKernelWidth(64);
  filter->SetNumberOfWorkUnits(1);
  filter->Update();
  return filter->GetOutput();
}

Lattice lattice_of(const Image& image, const LabelMap& map, const Crop& crop) {
  Lattice lattice{crop.size, {}, map.spacing, {}};
  lattice.origin = {map.spacing.x * crop.lower[0], map.spacing.y * crop.lower[1],
                    map.spacing.z * crop.lower[2]};
  const auto count = image.GetLargestPossibleRegion().GetNumberOfPixels();
  lattice.values.assign(image.GetBufferPointer(), image.GetBufferPointer() + count);
  return lattice;
}

}  // namespace

Lattice blurred_mask(const LabelMap& map, const LabelExtent& extent, const Shaping& shaping) {
  const Crop crop = crop_of(extent, map, shaping);
  const auto mask = mask_of<Image>(map, crop, [&](std::int32_t found) { return found == extent.label; });
  return lattice_of(*blurred(mask, shaping.smoothing), map, crop);
}

double blur_width(const LabelMap& map, const Shaping& shaping) {
  const double voxel = map.spacing.x * map.spacing.y * map.spacing.z;
  return std::max(shaping.smoothing, 0.4) * std::cbrt(voxel) * std::sqrt(2.0 * std::numbers::pi);
}

std::optional<Lattice> distance_to_labels(const LabelMap& map, const LabelExtent& extent,
                                          const Shaping& shaping,
                                          const std::function<bool(std::int32_t)>& counts) {
  const Crop crop = crop_of(extent, map, shaping);
  bool any = false;
  const auto others = mask_of<Mask>(map, crop, [&](std::int32_t found) {
    const bool other = counts(found);
    any = any || other;
    return other;
  });
  if (!any) return std::nullopt;
  const auto filter = itk::SignedMaurerDistanceMapImageFilter<Mask, Image>::New();
  filter->SetInput(others);
  filter->SetSquaredDistance(false);
  filter->SetUseImageSpacing(true);
  filter->SetInsideIsPositive(false);
  filter->SetNumberOfWorkUnits(1);
  filter->Update();
  Lattice distance = lattice_of(*blurred(filter->GetOutput(), shaping.smoothing), map, crop);
  // ITK measures the distance to the centre of the border voxels, half a voxel beyond the face.
  const auto half = static_cast<float>(0.5 * std::max({map.spacing.x, map.spacing.y, map.spacing.z}));
  for (float& value : distance.values) value -= half;
  return distance;
}

Lattice label_field(const LabelMap& map, const LabelExtent& extent, const Shaping& shaping) {
  Lattice field = blurred_mask(map, extent, shaping);
  const double voxel = map.spacing.x * map.spacing.y * map.spacing.z;
  const double level = level_of_volume(field, static_cast<double>(extent.voxels) * voxel);
  const double width = blur_width(map, shaping);
  for (float& value : field.values) value = static_cast<float>((static_cast<double>(value) - level) * width);
  if (shaping.gap <= 0.0) return field;
  const auto is_other = [&](std::int32_t found) { return found != 0 && found != extent.label; };
  if (const auto distance = distance_to_labels(map, extent, shaping, is_other)) {
    const auto half_gap = static_cast<float>(0.5 * shaping.gap);
    for (std::size_t p = 0; p < field.values.size(); ++p) {
      field.values[p] = std::min(field.values[p], distance->values[p] - half_gap);
    }
  }
  return field;
}

}  // namespace palpate::app
