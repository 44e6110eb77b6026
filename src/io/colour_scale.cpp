#include "io/colour_scale.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "io/picture_text.hpp"

namespace palpate::io {
namespace {

using Rgb = std::array<float, 3>;

constexpr std::array<Rgb, 11> viridis{{{0.267F, 0.005F, 0.329F},
                                       {0.283F, 0.141F, 0.458F},
                                       {0.254F, 0.265F, 0.530F},
                                       {0.207F, 0.372F, 0.553F},
                                       {0.164F, 0.471F, 0.558F},
                                       {0.128F, 0.567F, 0.551F},
                                       {0.135F, 0.659F, 0.518F},
                                       {0.267F, 0.749F, 0.441F},
                                       {0.478F, 0.821F, 0.318F},
                                       {0.741F, 0.873F, 0.150F},
                                       {0.993F, 0.906F, 0.144F}}};

/// At most three significant digits, without trailing zeros.
std::string number(double value) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.3g", value);
  return {text.data(), static_cast<std::size_t>(length)};
}

}  // namespace

double nice_above(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 0.0;
  constexpr double rounding = 1e-9;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (factor * power >= value * (1.0 - rounding)) return factor * power;
  }
  return 10.0 * power;
}

Rgb scale_colour(double value, const ColourScale& scale) {
  const double fraction =
      std::isfinite(value) ? std::clamp((value - scale.least) / (scale.most - scale.least), 0.0, 1.0) : 0.0;
  const double place = fraction * (viridis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), viridis.size() - 2);
  const auto between = static_cast<float>(place - static_cast<double>(low));
  Rgb colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = viridis[low][c] + between * (viridis[low + 1][c] - viridis[low][c]);
  return colour;
}

void draw_scale(Image& image, const ColourScale& scale, int bottom) {
  const int height = image.height - bottom;
  const int unit = std::max(2, height / 40);
  const int top = 4 * unit;
  const int end = height - 4 * unit;
  const int right = image.width - 4 * unit;
  const int left = right - unit;
  for (int y = top; y < end; ++y) {
    const double fraction = static_cast<double>(end - 1 - y) / std::max(1, end - 1 - top);
    const Rgb colour = scale_colour(scale.least + fraction * (scale.most - scale.least), scale);
    for (int x = std::max(left, 0); x < right; ++x) {
      for (std::size_t c = 0; c < 3; ++c)
        image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::lround(255.0F * colour[c]));
    }
  }
  for (const double fraction : {0.0, 0.5, 1.0}) {
    const int y = static_cast<int>(std::lround(end - 1 - fraction * (end - 1 - top)));
    draw_text(image, number(scale.least + fraction * (scale.most - scale.least)), unit, right + unit / 2, y,
              TextSide::right);
  }
  draw_text(image, scale.label, unit, right + 3 * unit, 2 * unit, TextSide::left);
}

}  // namespace palpate::io
