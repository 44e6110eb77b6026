#include "run_pictures.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "geometry/vector.hpp"
#include "io/picture.hpp"
#include "io/picture_cut.hpp"
#include "numbers.hpp"
#include "scene/body_colour.hpp"
#include "scene/field_values.hpp"
#include "status_line.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

std::string caption(const RunImages& run) {
  const StepMetrics& m = run.simulation.metrics();
  return fmt::format("{}: step {}, t = {} {}, {}{}", run.scene.name, m.step, short_text(m.time),
                     run.scene.units.time, counted(m.detection.contacts, "contact"),
                     run.outcome.at_rest ? ", at rest" : "");
}

/// Colours of the bodies, then of the regions, in the order of the model's materials.
std::vector<io::Colour> colours(const Scene& scene) {
  std::vector<io::Colour> list;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    list.push_back(body_colour(scene.bodies[b], static_cast<Index>(b)));
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    for (const Region& region : scene.bodies[b].regions)
      list.push_back(region.color ? io::to_colour(*region.color) : list[b]);
  }
  return list;
}

/// The colours for views of values: bodies without values are grey, so that no colour looks like a value.
std::vector<io::Colour> colours_without_values(const Scene& scene, std::span<const std::uint8_t> coloured) {
  std::vector<io::Colour> list;
  for (const std::uint8_t one : coloured) list.push_back(one != 0 ? io::no_value_colour : io::neutral_colour);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    list.insert(list.end(), scene.bodies[b].regions.size(), list[b]);
  return list;
}

/// 1 for each named body; without names, for each body with otherwise(body).
template <class Otherwise>
std::vector<std::uint8_t> flags(const Scene& scene, const BodyNames& bodies, Otherwise&& otherwise) {
  std::vector<std::uint8_t> list;
  list.reserve(scene.bodies.size());
  for (const SceneBody& body : scene.bodies) {
    const bool named = std::ranges::count(bodies.names, body.name) > 0;
    list.push_back(named || (bodies.names.empty() && otherwise(body)) ? 1 : 0);
  }
  return list;
}

/// (n_bodies) 1: the body is present at the start of the run, or now.
std::vector<std::uint8_t> present(const RunImages& run, bool at_start) {
  std::vector<std::uint8_t> list;
  for (std::size_t b = 0; b < run.scene.bodies.size(); ++b) {
    const bool there =
        at_start ? !run.scene.bodies[b].absent : run.simulation.is_present(static_cast<Index>(b));
    list.push_back(there ? 1 : 0);
  }
  return list;
}

/// Values at points, and their colour scale in the unit of display.
struct Coloured {
  std::vector<double> values;  ///< (n_points), NaN where the view does not show it
  std::optional<io::ColourScale> scale{};
  std::vector<std::uint8_t> bodies{};  ///< (n_bodies) 1: the body has values; empty without a colour scale
};

std::vector<std::uint8_t> coloured_bodies(const Scene& scene, const BodyNames& bodies) {
  return flags(scene, bodies, [](const SceneBody& body) { return !is_rigid(body); });
}

/// Blanks the points of bodies that are not coloured.
void keep_coloured(const RunImages& run, Coloured& shown) {
  for (std::size_t p = 0; p < shown.values.size(); ++p) {
    if (at(shown.bodies, run.simulation.bodies().body_of_point()[p]) == 0)
      shown.values[p] = std::numeric_limits<double>::quiet_NaN();
  }
}

/// The largest value of the bodies that are coloured and shown.
double largest_seen(const RunImages& run, const Coloured& shown, const BodyNames& seen) {
  const auto is_seen = flags(run.scene, seen, [](const SceneBody&) { return true; });
  double most = 0.0;
  for (std::size_t p = 0; p < shown.values.size(); ++p) {
    if (at(is_seen, run.simulation.bodies().body_of_point()[p]) != 0 && shown.values[p] > most)
      most = shown.values[p];
  }
  return most;
}

/// Lengths of displacements from rest.
Coloured displacements(const RunImages& run, const DisplacementMap& map, std::span<const Vec3> positions) {
  Coloured shown{.values = std::vector<double>(positions.size()),
                 .bodies = coloured_bodies(run.scene, map.bodies)};
  for (std::size_t p = 0; p < positions.size(); ++p)
    shown.values[p] = length(positions[p] - run.simulation.bodies().points_rest()[p]);
  keep_coloured(run, shown);
  shown.scale = io::ColourScale{map.most, "displacement, " + run.scene.units.length};
  return shown;
}

/// A field at the end of the run.
Coloured field(const RunImages& run, const FieldMap& map, const BodyNames& seen) {
  Coloured shown{.values = point_scalars(run.simulation, map.name),
                 .bodies = coloured_bodies(run.scene, map.bodies)};
  keep_coloured(run, shown);
  double most = map.most ? *map.most : io::nice_above(largest_seen(run, shown, seen));
  if (!(most > map.least)) most = map.least + 1.0;  // if all values are equal, any scale will do
  const UnitForPeople unit = unit_for_people(most, run.scene.units, find_field(map.name)->dimension);
  for (double& value : shown.values) value *= unit.factor;
  std::string label(find_field(map.name)->title);
  if (!unit.name.empty()) label += ", " + unit.name;
  shown.scale = io::ColourScale{unit.factor * most, label, unit.factor * map.least};
  return shown;
}

Coloured coloured(const RunImages& run, const View& view, bool at_start, std::span<const Vec3> positions) {
  if (view.displacement) return displacements(run, *view.displacement, positions);
  if (view.field && !at_start) return field(run, *view.field, view.bodies);
  return {.values = std::vector<double>(positions.size(), std::numeric_limits<double>::quiet_NaN())};
}

io::Image render_view(const RunImages& run, const View& view, bool at_start, int width) {
  const auto all = [](const SceneBody&) { return true; };
  const std::span<const Vec3> positions = at_start ? run.start : run.simulation.positions();
  const Coloured shown = coloured(run, view, at_start, positions);
  io::CutSettings cut{.shown = flags(run.scene, view.bodies, all), .cut = {}, .point = {}, .normal = {}};
  const std::vector<std::uint8_t> there = present(run, at_start);
  for (std::size_t b = 0; b < there.size(); ++b) cut.shown[b] &= there[b];
  cut.cut.resize(cut.shown.size(), 0);
  if (view.cut) {
    cut.cut = flags(run.scene, view.cut->bodies, all);
    cut.point = view.cut->point;
    cut.normal = view.cut->normal;
  }
  const io::CutSurface surface = io::cut_open(run.simulation.bodies(), positions, shown.values, cut);
  std::vector<Index> colour_of_triangle;
  for (const Index tet : run.material_of_tet.empty() ? std::vector<Index>{} : surface.tet_of_triangle)
    colour_of_triangle.push_back(at(run.material_of_tet, tet));
  std::vector<Index> dots;
  if (view.contacts && !at_start) dots = run.simulation.detector().contacts().point;
  io::PictureSettings settings{.width = width,
                               .height = view.size[1],
                               .camera = view.camera.position,
                               .target = view.camera.target,
                               .caption = {}};
  const double time = at_start ? 0.0 : run.simulation.metrics().time;
  settings.caption = fmt::format("{}, t = {} {}", run.scene.name, short_text(time), run.scene.units.time);
  settings.scale = shown.scale;
  return io::render_picture(
      {.positions = surface.points,
       .triangles = surface.triangles,
       .body_of_point = surface.body_of_point,
       .contact_points = dots,
       .body_colours = shown.scale ? colours_without_values(run.scene, shown.bodies) : colours(run.scene),
       .values = surface.values,
       .colour_of_triangle = colour_of_triangle,
       .edges = surface.edges},
      settings, parallel::Threads(run.threads));
}

io::Image side_by_side(const io::Image& left, const io::Image& right) {
  io::Image both(left.width + right.width, left.height);
  for (int y = 0; y < both.height; ++y) {
    std::copy_n(left.pixel(0, y), 3 * left.width, both.pixel(0, y));
    std::copy_n(right.pixel(0, y), 3 * right.width, both.pixel(left.width, y));
  }
  return both;
}

io::Image render_view(const RunImages& run, const View& view) {
  const int width = view.size[0];
  if (view.when != ViewTime::both) return render_view(run, view, view.when == ViewTime::start, width);
  return side_by_side(render_view(run, view, true, width / 2),
                      render_view(run, view, false, width - width / 2));
}

}  // namespace

std::vector<fs::path> picture_paths(const fs::path& folder, const Scene& scene) {
  std::vector<fs::path> paths{folder / "picture.png"};
  paths.reserve(1 + scene.output.views.size());
  for (const View& view : scene.output.views) paths.push_back(folder / (view.name + ".png"));
  return paths;
}

namespace {

/// Draws the whole scene with its bodies that are present. If there are regions, tissues have the colours of
/// their regions.
void render_main_picture(const RunImages& run, const fs::path& path) {
  const Picture& picture = run.scene.output.picture;
  const std::vector<std::uint8_t> there = present(run, false);
  if (std::ranges::count(there, 0) > 0 || !run.material_of_tet.empty()) {
    const View view{.name = {}, .size = picture.size, .camera = picture.camera, .contacts = true};
    return io::write_png(path, render_view(run, view));
  }
  io::render_picture(path, run.simulation.bodies(), run.simulation.positions(),
                     run.simulation.detector().contacts().point, colours(run.scene),
                     {.width = picture.size[0],
                      .height = picture.size[1],
                      .camera = picture.camera.position,
                      .target = picture.camera.target,
                      .caption = caption(run)},
                     parallel::Threads(run.threads));
}

}  // namespace

void render_pictures(const RunImages& run, bool quiet) {
  StatusLine status(quiet);
  status.show([](std::size_t width) { return std::string("drawing the picture ...").substr(0, width); });
  const std::vector<fs::path> paths = picture_paths(run.folder, run.scene);
  render_main_picture(run, paths.front());
  for (std::size_t i = 0; i < run.scene.output.views.size(); ++i)
    io::write_png(paths[i + 1], render_view(run, run.scene.output.views[i]));
  status.clear();
}

std::vector<fs::path> stage_picture_paths(const fs::path& folder, const Scene& scene,
                                          const std::string& stage) {
  std::vector<fs::path> paths{folder / "stages" / (stage + ".png")};
  for (const View& view : scene.output.views)
    paths.push_back(folder / "stages" / (stage + "." + view.name + ".png"));
  return paths;
}

void StagePictures::take(const std::string& stage, const RunOutcome& outcome) const {
  const RunImages run{folder_, scene_, simulation_, start_, material_of_tet_, outcome, threads_};
  fs::create_directories(folder_ / "stages");
  const std::vector<fs::path> paths = stage_picture_paths(folder_, scene_, stage);
  render_main_picture(run, paths.front());
  for (std::size_t i = 0; i < scene_.output.views.size(); ++i) {
    View view = scene_.output.views[i];
    view.when = ViewTime::end;
    io::write_png(paths[i + 1], render_view(run, view));
  }
}

}  // namespace palpate::app
