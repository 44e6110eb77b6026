#include "conforming_output.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "conforming_report.hpp"
#include "geometry/vector.hpp"
#include "io/vtu_writer.hpp"
#include "mesh_inputs.hpp"
#include "mesh_scene.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

/// Transforms a mesh to world coordinates. Tets of a left-handed image get positive volume again.
void to_world(TetMesh& mesh, const Frame& frame) {
  const bool left_handed = dot(cross(frame.axes[0], frame.axes[1]), frame.axes[2]) < 0.0;
  for (Vec3& point : mesh.points) point = frame.to_world(point);
  if (!left_handed) return;
  for (Tet& tet : mesh.tets) std::swap(tet[2], tet[3]);
}

Index label_of(const NamedMap& map, int tissue) {
  return map.labels[static_cast<std::size_t>(tissue - 1)].extent.label;
}

void write_mesh(const fs::path& file, const TetMesh& mesh, const std::vector<int>& tissue_of_tet,
                const NamedMap& map) {
  std::vector<Index> labels;
  labels.reserve(tissue_of_tet.size());
  for (const int t : tissue_of_tet) labels.push_back(label_of(map, t));
  const std::vector<io::NamedArray> arrays{{.name = "label", .values = std::span<const Index>(labels)}};
  io::write_vtu(
      file, {.points = mesh.points, .tets = mesh.tets, .point_arrays = {}, .tet_arrays = arrays, .time = {}});
}

const std::string& body_name(const TissueBody& body, const NamedMap& map) {
  return map.labels[static_cast<std::size_t>(main_tissue(body, map) - 1)].name.name;
}

/// A body has the name and material of its largest tissue; its other tissues become regions.
std::vector<Region> regions_of(const TissueBody& body, const NamedMap& map) {
  std::vector<Region> regions;
  for (const int tissue : body.tissues) {
    if (tissue != main_tissue(body, map))
      regions.push_back({LabelSelection{label_of(map, tissue)}, first_tissue});
  }
  return regions;
}

/// The points of a soft body at which it is grown to a rigid tissue, as indices in the body's own mesh.
std::vector<Index> grown_points(const ConformingMesh& made, const TissueBody& body, int rigid,
                                const Relations& relations) {
  std::set<Index> found;
  for (const InterfaceFace& face : made.faces) {
    const int other = face.labels[0] == rigid ? face.labels[1] : face.labels[0];
    if (face.labels[0] != rigid && face.labels[1] != rigid) continue;
    if (std::ranges::count(body.tissues, other) == 0) continue;
    if (relations.between(rigid, other) != Relation::grown) continue;
    found.insert(face.points.begin(), face.points.end());
  }
  std::vector<Index> own;
  own.reserve(found.size());
  for (const Index p : found)
    own.push_back(static_cast<Index>(std::ranges::lower_bound(body.points, p) - body.points.begin()));
  return own;
}

/// Glues a soft body to the rigid ones that it is grown to: their points coincide. A point is attached to one
/// body only.
std::vector<Attachment> attachments_of(const ConformingMesh& made, const TissueBody& body,
                                       const TissuePlan& plan, const NamedMap& map) {
  std::vector<Attachment> attached;
  std::set<Index> held;
  for (const TissueBody& other : made.bodies) {
    if (!other.rigid || body.rigid) continue;
    PointSelection points;
    for (const Index p : grown_points(made, body, other.tissues.front(), plan.relations)) {
      if (held.insert(p).second) points.indices.push_back(p);
    }
    if (!points.indices.empty()) attached.push_back({body_name(other, map), std::move(points)});
  }
  return attached;
}

/// Lists the rigid bodies that a soft one is grown to wherever they touch, so that no surface is left for
/// contacts.
std::vector<std::string> glued_bodies(const ConformingMesh& made, const TissueBody& body,
                                      const TissuePlan& plan, const NamedMap& map) {
  std::vector<std::string> names;
  for (const TissueBody& other : made.bodies) {
    if (!other.rigid || body.rigid) continue;
    bool touches = false;
    bool all_grown = true;
    for (const InterfaceFace& face : made.faces) {
      const int rigid = other.tissues.front();
      const int soft = face.labels[0] == rigid ? face.labels[1] : face.labels[0];
      const bool meets = face.labels[0] == rigid || face.labels[1] == rigid;
      if (!meets || std::ranges::count(body.tissues, soft) == 0) continue;
      touches = true;
      all_grown = all_grown && plan.relations.between(rigid, soft) == Relation::grown;
    }
    if (touches && all_grown) names.push_back(body_name(other, map));
  }
  return names;
}

}  // namespace

int main_tissue(const TissueBody& body, const NamedMap& map) {
  return *std::ranges::max_element(body.tissues, {}, [&](int tissue) {
    return map.labels[static_cast<std::size_t>(tissue - 1)].extent.voxels;
  });
}

ConformingReport write_conforming(SceneFolder& folder, const MeshOptions& options, const NamedMap& map,
                                  const TissuePlan& plan, ConformingMesh made) {
  const Frame frame = in_space(map.map.frame, options.ras);
  Scene scene = first_scene(input_name(options));
  std::set<std::string> used{"tissues.vtu"};
  std::vector<BodyFile> files;
  for (TissueBody& body : made.bodies) {
    files.push_back({body_name(body, map), mesh_file_name(body_name(body, map), used)});
    to_world(body.mesh, frame);
    write_mesh(folder.place(files.back().file), body.mesh, body.tissue_of_tet, map);
    const auto main = static_cast<std::size_t>(main_tissue(body, map) - 1);
    scene.bodies.push_back(
        first_body(files.back().name, files.back().file, body.rigid, map.labels[main].name.color));
    if (!body.rigid) scene.bodies.back().regions = regions_of(body, map);
    scene.bodies.back().attached = attachments_of(made, body, plan, map);
    scene.bodies.back().no_contact.names = glued_bodies(made, body, plan, map);
  }
  to_world(made.mesh.mesh, frame);
  write_mesh(folder.place("tissues.vtu"), made.mesh.mesh, made.mesh.labels, map);
  const std::vector<std::string> others = folder.commit(write_scene(scene));
  ConformingReport report = conforming_report(made, files, map, plan);
  add_warning_of_others(others, report.warnings);
  return report;
}

}  // namespace palpate::app
