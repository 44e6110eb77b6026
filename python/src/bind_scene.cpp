#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "arrays.hpp"
#include "bind.hpp"
#include "docs.hpp"
#include "io/volume_cells.hpp"
#include "model.hpp"
#include "scene/generators.hpp"
#include "scene/scene.hpp"
#include "scene/stage_run.hpp"

namespace palpate::python {
namespace {

nb::tuple arrays_of(TetMesh mesh) {
  return nb::make_tuple(moved<double>(std::move(mesh.points)), moved<Index>(std::move(mesh.tets)));
}

using CellsIn = ArrayIn<Index, -1, -1>;

std::vector<Tet> tets_of_cells(const std::string& kind, const PointsIn& points, const CellsIn& cells) {
  const std::size_t wanted = io::volume_corners(kind);
  if (wanted == 0 || cells.shape(1) < wanted)
    throw Error("tets_of_cells", "kind", "'" + kind + "'", "a kind of cell with a volume, and its corners");
  io::MeshFile file;
  file.mesh.points = vector_of(points_of(points));
  for (std::size_t cell = 0; cell < cells.shape(0); ++cell)
    io::add_volume_cell(file, kind, {cells.data() + cell * cells.shape(1), wanted});
  return std::move(file.mesh.tets);
}

constexpr auto mesh_sig = "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int32]]";

}  // namespace

void bind_scene(nb::module_& m) {
  nb::class_<Scene>(m, "Scene", doc::Scene)
      .def_static(
          "read", [](const std::string& file) { return read_scene(file); }, nb::arg("file"), doc::read_scene)
      .def_static(
          "parse",
          [](const std::string& text, std::string source, const std::string& folder) {
            return read_scene_text(text, std::move(source), folder);
          },
          nb::arg("text"), nb::arg("source"), nb::arg("folder") = "", doc::read_scene_text)
      .def_prop_ro(
          "text", [](const Scene& scene) { return write_scene(scene); }, doc::write_scene)
      .def_prop_ro(
          "folder", [](const Scene& scene) { return scene.folder.string(); }, doc::Scene_folder)
      .def("__repr__",
           [](const Scene& scene) {
             return "<palpate Scene '" + scene.name + "' of " + scene.source + ": " +
                    std::to_string(scene.bodies.size()) + " bodies>";
           })
      .def(
          "__reduce__",
          [](nb::handle self) {
            return nb::make_tuple(
                self.type().attr("parse"),
                nb::make_tuple(self.attr("text"), self.attr("source"), self.attr("folder")));
          },
          nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
      .def_ro("source", &Scene::source, doc::Scene_source)
      .def_ro("duration", &Scene::duration, doc::Scene_duration)
      .def_prop_ro(
          "stage_steps", [](const Scene& scene) { return most_steps_of_stages(scene); },
          "Steps that its stages take at most; 0 without stages.");
  m.def(
      "read_mesh", [](const std::string& path) { return arrays_of(read_checked_mesh(path)); },
      nb::arg("path"), nb::sig(("def read_mesh(path: str) -> " + std::string(mesh_sig)).c_str()),
      doc::read_checked_mesh);
  m.def(
      "tets_of_cells",
      [](const std::string& kind, const PointsIn& points, const CellsIn& cells) {
        return moved<Index>(tets_of_cells(kind, points, cells));
      },
      nb::arg("kind"), nb::arg("points"), nb::arg("cells"),
      nb::sig("def tets_of_cells(kind: str, points: numpy.typing.NDArray[numpy.float64], cells: "
              "numpy.typing.NDArray[numpy.int32]) -> numpy.typing.NDArray[numpy.int32]"),
      "The tets that read_mesh() makes of cells of one kind (\"hexahedron20\"). points: (n, 3). cells: (m, "
      "k), "
      "corners first, in VTK's order; their indices are not checked.");
  m.def(
      "mesh_extensions",
      [] {
        std::vector<std::string> names;
        for (const std::string_view name : io::mesh_extensions()) names.emplace_back(name);
        return names;
      },
      doc::mesh_extensions);
  m.def(
      "box",
      [](const std::array<int, 3>& cells, const std::array<double, 3>& size) {
        return arrays_of(make_box(cells, {size[0], size[1], size[2]}));
      },
      nb::arg("cells"), nb::arg("size"),
      nb::sig(
          ("def box(cells: typing.Sequence[int], size: typing.Sequence[float]) -> " + std::string(mesh_sig))
              .c_str()),
      doc::make_box);
  m.def(
      "ball", [](double radius, int resolution) { return arrays_of(make_ball(radius, resolution)); },
      nb::arg("radius"), nb::arg("resolution"),
      nb::sig(("def ball(radius: float, resolution: int) -> " + std::string(mesh_sig)).c_str()),
      doc::make_ball);
  m.def(
      "stacking_scene",
      [](int count, const std::array<int, 3>& cells, std::uint32_t seed) {
        return make_stacking_scene({.count = count, .cells = cells, .seed = seed});
      },
      nb::arg("count"), nb::arg("cells"), nb::arg("seed"), doc::make_stacking_scene);
}

}  // namespace palpate::python
