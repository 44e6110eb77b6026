#include "io/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/picture_cut.hpp"
#include "results/support.hpp"

namespace palpate::test {
namespace {

using io::Colour;
using io::Image;
using io::PictureSettings;
using parallel::Threads;

constexpr Colour pure_blue{0.05F, 0.15F, 0.9F};
constexpr Colour black{0.0F, 0.0F, 0.0F};

double luminance(const std::uint8_t* pixel) {
  return 0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2];
}

/// The dot's red, up to rounding.
bool is_contact_red(const std::uint8_t* pixel) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(pixel[c] - 255.0 * io::contact_colour[c]) > 1.5) return false;
  }
  return true;
}

int count_contact_red(const Image& image) {
  int count = 0;
  for (std::size_t i = 0; i < image.bytes.size(); i += 3) count += is_contact_red(&image.bytes[i]) ? 1 : 0;
  return count;
}

/// A box of 2 x 2 x 2 around the origin, seen from (0, -8, 0) along +y: its front face is a square in the
/// middle.
class PictureTest : public ::testing::Test {
 protected:
  void SetUp() override { ::unsetenv("DISPLAY"); }
  PictureTest() {
    bodies_.add("box", box_mesh({-1, -1, -1}, {1, 1, 1}, 2));
    positions_.assign(bodies_.points_rest().begin(), bodies_.points_rest().end());
    settings_ = {.width = 160,
                 .height = 120,
                 .camera = Vec3{0, -8, 0},
                 .target = Vec3{0, 0, 0},
                 .edges = false,
                 .caption = ""};
  }
  [[nodiscard]] Image take(int threads = 1) const {
    return io::render_picture({.positions = positions_,
                               .triangles = bodies_.triangles(),
                               .body_of_point = bodies_.body_of_point(),
                               .contact_points = contacts_,
                               .body_colours = colours_},
                              settings_, Threads(threads));
  }
  [[nodiscard]] Index point_at(const Vec3& place) const {
    return static_cast<Index>(std::ranges::find(positions_, place) - positions_.begin());
  }
  Bodies bodies_;
  std::vector<Vec3> positions_;
  std::vector<Index> contacts_;
  std::vector<Colour> colours_{pure_blue};
  PictureSettings settings_;
};

TEST_F(PictureTest, PngDecodesToTheSamePixelsWithoutADisplay) {
  ASSERT_EQ(std::getenv("DISPLAY"), nullptr);
  const TemporaryFolder folder;
  settings_.caption = "box    step 3    t = 0.03 s";
  io::render_picture(folder / "picture.png", bodies_, positions_, contacts_, colours_, settings_, Threads(2));
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName((folder / "picture.png").c_str());
  reader->Update();
  vtkImageData* decoded = reader->GetOutput();
  ASSERT_EQ(decoded->GetDimensions()[0], 160);
  ASSERT_EQ(decoded->GetDimensions()[1], 120);
  ASSERT_EQ(decoded->GetNumberOfScalarComponents(), 3);
  const Image image = take();
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const auto* found = static_cast<const std::uint8_t*>(decoded->GetScalarPointer(x, 119 - y, 0));
      ASSERT_TRUE(std::equal(found, found + 3, image.pixel(x, y))) << x << ", " << y;
    }
  }
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"picture.png"});
}

TEST_F(PictureTest, BodyInTheMiddleBackgroundAround) {
  const Image image = take();
  const std::uint8_t* middle = image.pixel(80, 60);
  EXPECT_GT(middle[2], 2 * middle[1]);
  EXPECT_GT(middle[2], 2 * middle[0]);
  EXPECT_GT(middle[2], 80);
  for (const int x : {0, 159}) {
    for (const int y : {0, 119}) EXPECT_GT(luminance(image.pixel(x, y)), 215.0) << x << ", " << y;
  }
}

TEST_F(PictureTest, SilhouetteIsWherePerspectivePutsIt) {
  colours_ = {black};
  const Image image = take();
  // The front face, 7 away, is 2 wide; 26 degrees cover the height.
  const double half = 60.0 / std::tan(13.0 * std::acos(-1.0) / 180.0) / 7.0;
  for (const double side : {-1.0, 1.0}) {
    EXPECT_LT(luminance(image.pixel(static_cast<int>(80 + side * (half - 2)), 60)), 60.0);
    EXPECT_GT(luminance(image.pixel(static_cast<int>(80 + side * (half + 2)), 60)), 120.0);
    EXPECT_LT(luminance(image.pixel(80, static_cast<int>(60 + side * (half - 2)))), 60.0);
  }
  EXPECT_GT(luminance(image.pixel(80, static_cast<int>(60 - half - 2))), 120.0);
}

TEST_F(PictureTest, BodyColoursAreTheGivenOrTheDefaultOnes) {
  colours_.clear();
  const Image image = take();
  const Colour expected = io::default_colour(0);
  const std::uint8_t* middle = image.pixel(80, 60);
  EXPECT_EQ(middle[0] < middle[1], expected[0] < expected[1]);
  EXPECT_EQ(middle[1] < middle[2], expected[1] < expected[2]);
  for (Index a = 0; a < 6; ++a) {
    for (Index b = 0; b < a; ++b) EXPECT_NE(io::default_colour(a), io::default_colour(b));
  }
  EXPECT_EQ(io::default_colour(6), io::default_colour(0));
}

TEST_F(PictureTest, EdgesDarkenOnlyTheLines) {
  // Triangle edges cross the middle of the front face; the point (1/4, 1/8) of a cell is on no edge.
  const Image plain = take();
  settings_.edges = true;
  const Image lined = take();
  EXPECT_LT(luminance(lined.pixel(80, 60)), 0.8 * luminance(plain.pixel(80, 60)));
  int changed = 0, darker = 0;
  for (std::size_t i = 0; i < plain.bytes.size(); i += 3) {
    changed += std::equal(&plain.bytes[i], &plain.bytes[i] + 3, &lined.bytes[i]) ? 0 : 1;
    darker += luminance(&lined.bytes[i]) < luminance(&plain.bytes[i]) ? 1 : 0;
  }
  EXPECT_EQ(changed, darker);
  EXPECT_GT(changed, 100);
  EXPECT_LT(changed, 74 * 74 / 2);  // the face covers about 74 x 74 pixels
}

TEST_F(PictureTest, ContactDotAtItsPoint) {
  settings_.target = Vec3{0, -1, 0};
  EXPECT_EQ(count_contact_red(take()), 0);
  contacts_ = {point_at({0, -1, 0})};
  const Image once = take();
  for (const int x : {79, 80}) {
    for (const int y : {59, 60}) EXPECT_TRUE(is_contact_red(once.pixel(x, y))) << x << ", " << y;
  }
  EXPECT_FALSE(is_contact_red(once.pixel(70, 60)));
  contacts_.push_back(contacts_[0]);
  EXPECT_EQ(take().bytes, once.bytes);
}

TEST_F(PictureTest, HiddenDotShowsFaintly) {
  settings_.target = Vec3{0, 1, 0};
  const Image none = take();
  contacts_ = {point_at({0, 1, 0})};  // on the back face
  const Image hidden = take();
  contacts_ = {point_at({0, -1, 0})};
  const Image seen = take();
  const int red_none = none.pixel(80, 60)[0];
  const int red_hidden = hidden.pixel(80, 60)[0];
  EXPECT_GT(red_hidden, red_none + 20);
  EXPECT_LT(red_hidden, seen.pixel(80, 60)[0] - 20);
}

TEST_F(PictureTest, SameBytesForEveryThreadCount) {
  bodies_.add("second", box_mesh({-1, -1, 1}, {0.5, 1, 1.5}, 3));  // touches the first: surfaces coincide
  positions_.assign(bodies_.points_rest().begin(), bodies_.points_rest().end());
  colours_.clear();
  settings_ = {
      .width = 133, .height = 101, .camera = {}, .target = {}, .edges = true, .caption = "two boxes"};
  contacts_ = {3, 9, 14, 30, 40};
  const Image one = take(1);
  EXPECT_EQ(take(2).bytes, one.bytes);
  EXPECT_EQ(take(3).bytes, one.bytes);
  EXPECT_EQ(take(7).bytes, one.bytes);
}

TEST_F(PictureTest, UnitsDoNotMatter) {
  settings_ = {.width = 80, .height = 60, .camera = {}, .target = {}, .edges = true, .caption = ""};
  const Image metres = take();
  const auto original = positions_;
  for (const double scale : {0x1p-40, 0x1p+60}) {
    std::ranges::transform(original, positions_.begin(), [&](const Vec3& p) {
      return Vec3{scale * p.x, scale * p.y, scale * p.z};
    });
    EXPECT_EQ(take().bytes, metres.bytes) << scale;
  }
}

TEST_F(PictureTest, AutomaticViewHoldsAllAndFillsTheFrame) {
  colours_ = {black, black};
  bodies_.add("far", box_mesh({7, 4, 3}, {8, 5, 9}, 1));
  positions_.assign(bodies_.points_rest().begin(), bodies_.points_rest().end());
  settings_.camera.reset();
  settings_.target.reset();
  const Image image = take();
  int left = 160, right = 0, top = 120, bottom = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (luminance(image.pixel(x, y)) > 60.0) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  const int space = std::min({left, 159 - right, top, 119 - bottom});
  EXPECT_GE(space, 6);
  EXPECT_LE(space, 9);
}

TEST_F(PictureTest, ABodyAboveCastsAShadow) {
  bodies_ = Bodies();
  bodies_.add("plate", box_mesh({-3, -3, -0.2}, {3, 3, 0}, 4));
  bodies_.add("roof", box_mesh({-0.5, -0.5, 0.3}, {0.5, 0.5, 0.6}, 2));
  const auto rest = bodies_.points_rest();
  positions_.assign(rest.begin(), rest.end());
  colours_ = {pure_blue, pure_blue};
  settings_.camera = Vec3{0, -6, 1.5};  // sees below the upper body
  const double shaded = luminance(take().pixel(80, 60));
  for (Index i = bodies_.bodies()[1].points.begin; i < bodies_.bodies()[1].points.end; ++i) {
    positions_[static_cast<std::size_t>(i)].x += 2.2;
  }
  const double open = luminance(take().pixel(80, 60));
  EXPECT_LT(shaded, 0.75 * open);
}

TEST_F(PictureTest, PositionsThatAreNotFiniteAreLeftOut) {
  const Image alone = take();
  bodies_.add("exploded", box_mesh({4, 0, 0}, {5, 1, 1}, 1));
  positions_.assign(bodies_.points_rest().begin(), bodies_.points_rest().end());
  colours_ = {pure_blue, black};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (std::size_t i = 27; i < positions_.size(); ++i)
    positions_[i] = i % 2 == 0 ? Vec3{nan, 0, 0} : Vec3{0, -infinity, 0};
  contacts_ = {30};
  EXPECT_EQ(take().bytes, alone.bytes);
  for (Vec3& p : positions_) p.z = nan;
  EXPECT_THROW(static_cast<void>(take()), Error);
}

/// Columns and rows of the lowest 40 rows that hold ink: darker than any background or shadow there.
struct Ink {
  int columns = 0, left = 10'000, right = -1, top = 10'000, bottom = -1;
  explicit Ink(const Image& image) {
    for (int x = 0; x < image.width; ++x) {
      bool found = false;
      for (int y = image.height - 40; y < image.height; ++y) {
        if (luminance(image.pixel(x, y)) > 120.0) continue;
        found = true;
        top = std::min(top, y);
        bottom = std::max(bottom, y);
        left = std::min(left, x);
        right = std::max(right, x);
      }
      columns += found ? 1 : 0;
    }
  }
};

TEST_F(PictureTest, CaptionIsWrittenInItsStripAndShrinksToFit) {
  settings_.width = 640;
  settings_.height = 720;
  settings_.camera = Vec3{0, -90, 0};  // small, so fast to draw
  EXPECT_EQ(Ink(take()).columns, 0);
  settings_.caption = "stacking    step 200";
  const Ink shorter(take());
  EXPECT_GT(shorter.columns, 60);
  EXPECT_GE(shorter.top, 720 - 40);
  EXPECT_LT(shorter.bottom, 718);
  EXPECT_GT(shorter.left, 5);
  for (int i = 0; i < 6; ++i) settings_.caption += "    3838 contacts";
  const Ink longer(take());
  EXPECT_GT(longer.right, 540);
  EXPECT_LT(longer.right, 630);
  EXPECT_LT(longer.bottom - longer.top, shorter.bottom - shorter.top);
}

TEST_F(PictureTest, CaptionBeyondAsciiBecomesQuestionMarks) {
  settings_.caption = "m\xc3\xbcsli\n";
  const Image image = take();
  settings_.caption = "m?sli ";
  EXPECT_EQ(take().bytes, image.bytes);
  settings_.caption = "msli ";
  EXPECT_NE(take().bytes, image.bytes);
}

TEST_F(PictureTest, RefusesWhatDoesNotFit) {
  const auto message_of = [&] {
    try {
      static_cast<void>(take());
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("no Error");
  };
  const PictureSettings good = settings_;
  settings_.width = 0;
  EXPECT_EQ(message_of(), "picture: width: found 0, expected 16 to 16384 pixels");
  settings_ = good;
  settings_.camera = settings_.target;
  EXPECT_EQ(message_of(),
            "picture: camera: found the target itself, expected a position away from the target");
  settings_ = good;
  settings_.target->x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message_of().find("picture: target: "), std::string::npos);
  settings_ = good;
  contacts_ = {27};
  EXPECT_EQ(message_of(), "picture: contact_points: found point 27, expected an index below 27");
  contacts_ = {};
  bodies_.add("second", box_mesh({0, 0, 5}, {1, 1, 6}, 1));
  EXPECT_EQ(message_of(), "picture: body_of_point: found 35 values, expected 27");
  positions_.assign(bodies_.points_rest().begin(), bodies_.points_rest().end());
  EXPECT_EQ(message_of(), "picture: body_colours: found 1 colours, expected 2");
}

TEST_F(PictureTest, ValuesHaveTheColoursOfTheScale) {
  settings_.scale = io::ColourScale{2.0, "depth, m"};
  const auto dominant = [&](double value) {
    const std::vector<double> values(positions_.size(), value);
    const Image image = io::render_picture({.positions = positions_,
                                            .triangles = bodies_.triangles(),
                                            .body_of_point = bodies_.body_of_point(),
                                            .contact_points = {},
                                            .body_colours = colours_,
                                            .values = values},
                                           settings_, Threads(1));
    const std::uint8_t* pixel = image.pixel(80, 60);
    return std::array<double, 3>{double(pixel[0]), double(pixel[1]), double(pixel[2])};
  };
  const auto low = dominant(0.0);   // dark violet
  const auto high = dominant(2.0);  // yellow
  EXPECT_GT(low[2], 2.0 * low[1]);
  EXPECT_GT(high[0], 2.0 * high[2]);
  EXPECT_GT(high[1], 2.0 * high[2]);
  EXPECT_EQ(dominant(9.0), high) << "beyond the end of the scale";
  settings_.scale->least = -2.0;
  EXPECT_EQ(dominant(-2.0), low) << "the scale begins there";
  EXPECT_EQ(dominant(2.0), high);
  EXPECT_NE(dominant(0.0), low);
  settings_.scale->least = 0.0;
  const auto body = dominant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_GT(body[2], 2.0 * body[0]) << "no number: the body's own blue";
}

TEST_F(PictureTest, TheScaleIsDrawnOnTheRight) {
  const Image without = take();
  settings_.scale = io::ColourScale{3.0, "displacement, mm"};
  const Image with = take();
  int changed_left = 0;
  int changed_right = 0;
  for (int y = 0; y < with.height; ++y) {
    for (int x = 0; x < with.width; ++x) {
      const bool changed = !std::equal(with.pixel(x, y), with.pixel(x, y) + 3, without.pixel(x, y));
      (x < with.width / 2 ? changed_left : changed_right) += changed ? 1 : 0;
    }
  }
  EXPECT_EQ(changed_left, 0);
  EXPECT_GT(changed_right, 100);
}

TEST(ColourScale, GrowsBrighterFromEndToEnd) {
  double last = -1.0;
  for (int i = 0; i <= 20; ++i) {
    const Colour c = io::scale_colour(0.05 * i, {1.0, ""});
    const double brightness = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    EXPECT_GT(brightness, last);
    last = brightness;
  }
  EXPECT_EQ(io::scale_colour(-1.0, {1.0, ""}), io::scale_colour(0.0, {1.0, ""}));
}

/// Volume inside triangles by the divergence theorem: right only if they are closed.
double enclosed(const io::CutSurface& surface) {
  double six = 0.0;
  for (const Triangle& t : surface.triangles) {
    six += dot(at(surface.points, t[0]), cross(at(surface.points, t[1]), at(surface.points, t[2])));
  }
  return six / 6.0;
}

TEST_F(PictureTest, ACutLeavesAClosedSurfaceOfTheRightVolume) {
  const std::vector<double> values(positions_.size(), 1.0);
  for (const double height : {-0.7, -0.25, 0.0, 0.3}) {
    for (const Vec3& normal : {Vec3{0, 0, 1}, Vec3{0, -2, 0}}) {
      const Vec3 point = height * normalized(normal);
      const auto cut = io::cut_open(bodies_, positions_, values, {{1}, {1}, point, normal});
      EXPECT_NEAR(enclosed(cut), 4.0 * (1.0 + height), 1e-9) << height;
      Vec3 sum;  // of the areas: zero for a closed surface
      for (const Triangle& t : cut.triangles) {
        const Vec3& a = at(cut.points, t[0]);
        sum += cross(at(cut.points, t[1]) - a, at(cut.points, t[2]) - a);
        for (const Index p : t) EXPECT_LE(dot(at(cut.points, p) - point, normal), 1e-9);
      }
      EXPECT_LT(length(sum), 1e-9);
      EXPECT_EQ(cut.values.size(), cut.points.size());
      EXPECT_TRUE(std::ranges::all_of(cut.values, [](double v) { return std::abs(v - 1.0) < 1e-12; }));
    }
  }
  const auto whole = io::cut_open(bodies_, positions_, values, {{1}, {0}, {}, {0, 0, 1}});
  EXPECT_EQ(whole.triangles.size(), bodies_.triangles().size());
  EXPECT_TRUE(io::cut_open(bodies_, positions_, values, {{0}, {1}, {}, {0, 0, 1}}).triangles.empty());
}

/// On the cut plane and on the surface: the centre of each triangle is in its tet.
TEST_F(PictureTest, TrianglesOfACutKnowTheirTets) {
  const std::vector<double> values(positions_.size(), 1.0);
  const auto cut = io::cut_open(bodies_, positions_, values, {{1}, {1}, {0.1, 0, 0.2}, {1, 0.3, 2}});
  ASSERT_EQ(cut.tet_of_triangle.size(), cut.triangles.size());
  for (std::size_t i = 0; i < cut.triangles.size(); ++i) {
    const Triangle& t = cut.triangles[i];
    const Vec3 middle = (1.0 / 3.0) * (at(cut.points, t[0]) + at(cut.points, t[1]) + at(cut.points, t[2]));
    const Tet& tet = at(bodies_.tets(), cut.tet_of_triangle[i]);
    const auto volume = [&](std::array<Vec3, 4> p) {
      return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    };
    for (std::size_t corner = 0; corner < 4; ++corner) {
      std::array<Vec3, 4> p;
      for (std::size_t c = 0; c < 4; ++c) p[c] = at(positions_, tet[c]);
      p[corner] = middle;
      EXPECT_GE(volume(p), -1e-12) << i;
    }
  }
}

TEST(ColourScale, EndsThatNobodyChoseAreRound) {
  const std::vector<std::array<double, 2>> expected{{0.3, 0.5}, {1.0, 1.0}, {1.0001, 2.0}, {2.9, 5.0}, {5.1, 10.0},
                                                    {2e-7, 2e-7}, {740.0, 1000.0}, {0.0, 0.0}, {-3.0, 0.0}};
  for (const auto& [value, end] : expected) EXPECT_NEAR(io::nice_above(value), end, 1e-12 * end) << value;
}

/// Colours of triangles replace those of bodies.
TEST_F(PictureTest, TrianglesMayHaveColoursOfTheirOwn) {
  const std::vector<io::Colour> colours{{1, 0, 0}, {0, 0, 1}};
  std::vector<Index> own(bodies_.triangles().size(), 1);
  const auto redder_than_blue = [&] {
    const Image image = io::render_picture({.positions = positions_,
                                            .triangles = bodies_.triangles(),
                                            .body_of_point = bodies_.body_of_point(),
                                            .contact_points = {},
                                            .body_colours = colours,
                                            .colour_of_triangle = own},
                                           settings_, Threads(1));
    const std::uint8_t* middle = image.pixel(image.width / 2, image.height / 2);
    return middle[0] > middle[2];
  };
  EXPECT_FALSE(redder_than_blue());
  own.assign(own.size(), 0);
  EXPECT_TRUE(redder_than_blue());
  own.back() = 2;
  EXPECT_THROW(redder_than_blue(), Error);
}

TEST_F(PictureTest, UnwritablePathIsAnError) {
  EXPECT_THROW(io::render_picture("/nonexistent/a.png", bodies_, positions_, {}, {}, settings_, Threads(1)),
               Error);
}

}  // namespace
}  // namespace palpate::test
