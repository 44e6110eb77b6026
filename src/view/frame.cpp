#include "view/frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/vector.hpp"
#include "view/message.hpp"

namespace palpate::view {
namespace {

/// If there are more cells, they are not drawn, and the page gets only their number.
constexpr std::size_t most_cells = 1 << 16;

/// Writes vectors one after the other.
class Writer {
 public:
  Writer(std::span<float> place, const Vec3& origin) : place_(place), origin_(origin) {}
  void add(double value) { place_[next_++] = static_cast<float>(value); }
  void add_vector(const Vec3& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  void add_position(const Vec3& p) { add_vector(p - origin_); }

 private:
  std::span<float> place_;
  std::size_t next_ = 0;
  const Vec3& origin_;
};

void add_positions(Message& message, const char* name, std::span<const Index> points,
                   std::span<const Vec3> positions, const Vec3& origin) {
  Writer writer(message.add_floats(name, 3 * points.size()), origin);
  for (const Index point : points) writer.add_position(at(positions, point));
}

/// For each contact: position, direction, depth; vertex (-1 for an inner point), its body, penetrated body.
void add_contacts(Message& message, const Source& source, const Surface& surface) {
  const Contacts& contacts = source.detector().contacts();
  {
    Writer writer(message.add_floats("contacts", 7 * contacts.size()), source.stage().origin);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      writer.add_position(at(source.positions(), contacts.point[c]));
      writer.add_vector(contacts.direction[c]);
      writer.add(contacts.depth[c]);
    }
  }
  const std::span<std::int32_t> where = message.add_integers("contact_places", 3 * contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    where[3 * c] = surface.vertex_of(contacts.point[c]);
    where[3 * c + 1] = at(source.bodies().body_of_point(), contacts.point[c]);
    where[3 * c + 2] = contacts.body[c];
  }
}

/// Adds each edge contact: the middle of the inner part of the edge, direction and depth; no vertex; the
/// edge's body and the penetrated body.
void add_edge_contacts(Message& message, const Source& source) {
  const EdgeContacts& contacts = source.detector().edge_contacts();
  const Bodies& bodies = source.bodies();
  {
    Writer writer(message.add_floats("edge_contacts", 7 * contacts.size()), source.stage().origin);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const Edge& edge = at(bodies.edges(), contacts.edge[c]);
      const Vec3& first = at(source.positions(), edge[0]);
      const auto [in, out] = contacts.parameters[c];
      writer.add_position(first + 0.5 * (in + out) * (at(source.positions(), edge[1]) - first));
      writer.add_vector(contacts.direction[c]);
      writer.add(contacts.depth[c]);
    }
  }
  const std::span<std::int32_t> where = message.add_integers("edge_contact_places", 3 * contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    where[3 * c] = -1;
    where[3 * c + 1] = at(bodies.body_of_point(), at(bodies.edges(), contacts.edge[c])[0]);
    where[3 * c + 2] = contacts.body[c];
  }
}

/// For each border edge its two ends, the one in contact first; for each crossing its position.
void add_borders(Message& message, const Source& source) {
  const Detector& detector = source.detector();
  const std::span<const Vec3> positions = source.positions();
  const auto ends = [&](Index border_edge) {
    const BorderEdge& edge = at(detector.border_edges(), border_edge);
    return std::array{at(positions, at(detector.contacts().point, edge.contact)),
                      at(positions, edge.free_point)};
  };
  const std::size_t count = detector.border_edges().size();
  Writer edges(message.add_floats("border_edges", 6 * count), source.stage().origin);
  for (std::size_t e = 0; e < count; ++e) {
    for (const Vec3& end : ends(static_cast<Index>(e))) edges.add_position(end);
  }
  Writer crossings(message.add_floats("crossings", 3 * detector.crossings().size()), source.stage().origin);
  for (const Crossing& crossing : detector.crossings()) {
    const auto [in, out] = ends(crossing.border_edge);
    crossings.add_position(in + crossing.parameter * (out - in));
  }
}

/// For each field of this source, a number for each vertex, then for each of `inner`; NaN where it has no
/// value.
void add_fields(Message& message, const Source& source, const Surface& surface, std::span<const Index> inner,
                std::span<const std::string> names) {
  for (const std::string& name : names) {
    const std::vector<double> values = source.field(name);
    if (values.empty()) continue;
    const std::size_t count = surface.points().size() + inner.size();
    Writer writer(message.add_floats(name, count), source.stage().origin);
    for (const Index point : surface.points()) writer.add(at(values, point));
    for (const Index point : inner) writer.add(at(values, point));
  }
}

/// The four corners of each tet, as point numbers of the message (Surface::corner_of(): surface vertices
/// first).
void add_tets(Message& message, const Source& source, const Surface& surface) {
  const std::span<const Tet> tets = source.bodies().tets();
  const std::span<std::int32_t> corners = message.add_integers("tets", 4 * tets.size());
  std::size_t next = 0;
  for (const Tet& tet : tets) {
    for (const Index point : tet) corners[next++] = surface.corner_of(point);
  }
}

/// Lower corners of the cells that hold a point.
void add_cells(Message& message, const Source& source, nlohmann::ordered_json& header) {
  const CellDomain domain = source.detector().cell_domain();
  const auto coordinate = [&](double x, double lower, Index cells) {
    const auto cell = static_cast<std::int64_t>(std::floor((x - lower) / domain.cell_size));
    return std::clamp<std::int64_t>(cell, 0, cells - 1);
  };
  const auto [nx, ny, nz] = domain.cells;
  std::vector<std::int64_t> occupied;
  for (const Vec3& p : source.positions()) {
    occupied.push_back(coordinate(p.x, domain.lower.x, nx) +
                       nx * (coordinate(p.y, domain.lower.y, ny) + ny * coordinate(p.z, domain.lower.z, nz)));
  }
  std::sort(occupied.begin(), occupied.end());
  occupied.erase(std::unique(occupied.begin(), occupied.end()), occupied.end());
  header["occupied_cells"] = occupied.size();
  occupied.resize(std::min(occupied.size(), most_cells));
  Writer writer(message.add_floats("cells", 3 * occupied.size()), source.stage().origin);
  for (const std::int64_t cell : occupied) {
    const std::int64_t row = cell / nx;
    const std::int64_t layer = row / ny;
    const Vec3 place{static_cast<double>(cell % nx), static_cast<double>(row % ny),
                     static_cast<double>(layer)};
    writer.add_position(domain.lower + domain.cell_size * place);
  }
}

}  // namespace

std::string stage_message(const Source& source, const Surface& surface) {
  Message message;
  const std::span<const Vec3> rest = source.bodies().points_rest();
  add_positions(message, "rest", surface.points(), rest, source.stage().origin);
  add_positions(message, "inner_rest", surface.inner_points(), rest, source.stage().origin);
  add_tets(message, source, surface);
  const std::span<std::int32_t> corners = message.add_integers("triangles", 3 * surface.triangles().size());
  for (std::size_t t = 0; t < surface.triangles().size(); ++t) {
    std::copy(surface.triangles()[t].begin(), surface.triangles()[t].end(),
              corners.begin() + static_cast<std::ptrdiff_t>(3 * t));
  }
  nlohmann::ordered_json header = source.stage().about;
  const Vec3& origin = source.stage().origin;
  header["kind"] = "stage";
  header["origin"] = {origin.x, origin.y, origin.z};
  return message.finish(std::move(header));
}

std::string frame_message(const Source& source, const Surface& surface, const DisplayOptions& display,
                          nlohmann::ordered_json header) {
  Message message;
  header["kind"] = "frame";
  header["time"] = source.time();
  header["counts"] = source.counts();
  if (display.forces) header["forces"] = source.forces();
  const std::span<const Index> inner = display.inside ? surface.inner_points() : std::span<const Index>{};
  add_positions(message, "positions", surface.points(), source.positions(), source.stage().origin);
  if (display.inside) add_positions(message, "inner", inner, source.positions(), source.stage().origin);
  if (display.contacts) {
    add_contacts(message, source, surface);
    add_edge_contacts(message, source);
  }
  if (display.borders) add_borders(message, source);
  if (display.cells) add_cells(message, source, header);
  add_fields(message, source, surface, inner, display.fields);
  return message.finish(std::move(header));
}

}  // namespace palpate::view
