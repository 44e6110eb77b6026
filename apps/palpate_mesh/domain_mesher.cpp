#include "domain_mesher.hpp"

// Contains CGAL's mesher: compiling takes half a minute and 3 GB.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalDomain = CGAL::Labeled_mesh_domain_3<Kernel>;

/// A size field with the interface that CGAL expects.
struct CgalSize {
  using FT = Kernel::FT;            // NOLINT(readability-identifier-naming): CGAL looks for these names
  using Point_3 = Kernel::Point_3;  // NOLINT(readability-identifier-naming)
  using Index = CgalDomain::Index;
  const SizeField* size;
  FT operator()(const Point_3& p, int /*dimension*/, const Index& /*index*/) const {
    return (*size)({p.x(), p.y(), p.z()});
  }
};

using Triangulation = CGAL::Mesh_triangulation_3<CgalDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace parameters = CGAL::parameters;

}  // namespace
}  // namespace palpate::app

/// Prevents CGAL from writing files into the current folder if its refinement fails.
template <>
struct CGAL::Dump_c3t3<palpate::app::Complex, true> {  // NOLINT(readability-identifier-naming)
  void dump_c3t3(const palpate::app::Complex& /*complex*/, const std::string& /*prefix*/) const {}
};

namespace palpate::app {
namespace {

CgalDomain make_domain(const LabelledDomain& domain, const std::function<void()>& turn) {
  const auto label = [&](const Kernel::Point_3& p) {
    turn();
    return domain.label({p.x(), p.y(), p.z()});
  };
  const CGAL::Bbox_3 box(domain.lower.x, domain.lower.y, domain.lower.z, domain.upper.x, domain.upper.y,
                         domain.upper.z);
  return {label, box, parameters::relative_error_bound = 1e-4};
}

using Place = std::tuple<double, double, double>;

/// Points and their indices, in an order that does not depend on their addresses in CGAL.
std::map<Place, Index> sorted_points(const Complex& complex) {
  std::map<Place, Index> points;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    for (int i = 0; i < 4; ++i) {
      const auto& p = cell->vertex(i)->point();
      points.try_emplace({p.x(), p.y(), p.z()}, 0);
    }
  }
  Index next = 0;
  for (auto& [point, index] : points) index = next++;
  return points;
}

/// Moves the lowest corner to the front by an even permutation, which keeps the volume positive.
Tet lowest_first(Tet tet) {
  const auto lowest = std::ranges::min_element(tet) - tet.begin();
  if (lowest == 1) tet = {tet[1], tet[0], tet[3], tet[2]};
  if (lowest == 2) tet = {tet[2], tet[3], tet[0], tet[1]};
  if (lowest == 3) tet = {tet[3], tet[2], tet[1], tet[0]};
  while (tet[1] > tet[2] || tet[1] > tet[3]) tet = {tet[0], tet[2], tet[3], tet[1]};
  return tet;
}

LabelledMesh sorted_mesh(const Complex& complex, bool manifold) {
  const std::map<Place, Index> points = sorted_points(complex);
  std::vector<std::pair<Tet, int>> tets;
  std::set<Index> on_lines;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tet tet{};
    for (int i = 0; i < 4; ++i) {
      const auto& p = cell->vertex(i)->point();
      const Index index = points.at({p.x(), p.y(), p.z()});
      tet[static_cast<std::size_t>(i)] = index;
      if (cell->vertex(i)->in_dimension() == 1) on_lines.insert(index);
    }
    tets.emplace_back(lowest_first(tet), complex.subdomain_index(cell));
  }
  std::ranges::sort(tets);
  LabelledMesh sorted;
  sorted.manifold = manifold;
  sorted.line_points.assign(on_lines.begin(), on_lines.end());
  for (const auto& [place, index] : points) {
    sorted.mesh.points.push_back({std::get<0>(place), std::get<1>(place), std::get<2>(place)});
  }
  for (const auto& [tet, label] : tets) {
    sorted.mesh.tets.push_back(tet);
    sorted.labels.push_back(label);
  }
  return sorted;
}

/// Inserts the points of lines, with their balls as weights, and the seeds that are outside of all balls.
/// CGAL's own first points are where random rays hit interfaces, and miss small components.
void add_first_points(Complex& complex, const CgalDomain& domain, const LabelledDomain& shape) {
  auto& mesh = complex.triangulation();
  const auto add = [&](const Triangulation::Weighted_point& point, int dimension, const auto& index) {
    const auto vertex = mesh.insert(point);
    if (vertex == Complex::Vertex_handle()) return;  // hidden by others
    complex.set_dimension(vertex, dimension);
    complex.set_index(vertex, index);
  };
  for (const auto& [center, radius] : shape.lines) {
    add({{center.x, center.y, center.z}, radius * radius}, 1, domain.index_from_subdomain_index(0));
  }
  for (const auto& [place, labels] : shape.seeds) {
    const Kernel::Point_3 point(place.x, place.y, place.z);
    if (!shape.lines.empty()) {
      const auto& ball = mesh.point(mesh.nearest_power_vertex(point));
      if (CGAL::squared_distance(point, ball.point()) < ball.weight()) continue;
    }
    add(Triangulation::Weighted_point(point), 2,
        domain.index_from_surface_patch_index({labels[0], labels[1]}));
  }
}

/// The refined mesh; none where it would need more than `max_points`, or where CGAL cannot make the surface a
/// manifold.
std::optional<Complex> refined(const CgalDomain& domain, const LabelledDomain& shape,
                               const Criteria& criteria, std::size_t max_points, bool manifold) {
  CGAL::Mesh_error_code failed = CGAL::CGAL_MESH_3_NO_ERROR;
  try {
    std::optional<Complex> complex(std::in_place);
    add_first_points(*complex, domain, shape);
    const auto options = parameters::mesh_3_options(parameters::maximal_number_of_vertices = max_points,
                                                    parameters::pointer_to_error_code = &failed);
    CGAL::refine_mesh_3(*complex, domain, criteria, parameters::no_perturb(), parameters::no_exude(),
                        parameters::no_reset_c3t3(), options,
                        manifold ? parameters::manifold() : parameters::non_manifold());
    if (failed == CGAL::CGAL_MESH_3_NO_ERROR) return complex;
  } catch (const CGAL::Failure_exception&) {
    // Usually CGAL asks for the same point twice if the surface is no manifold.
    if (!manifold)
      throw Error("meshing", "", "an error in CGAL's refinement", "another size or number of tets");
  }
  return std::nullopt;
}

/// Thrown out of CGAL's exuder between two of its turns, where the mesh is whole.
struct ExuderIsDone {};

/// What CGAL's exuder calls after each turn.
struct TurnsLeft {
  std::size_t* left;
  const std::function<void()>* turn;
  void after_cell_pumped(std::size_t /*cells_left*/) const {
    if (*left == 0) throw ExuderIsDone{};
    --*left;
    (*turn)();
  }
};

/// CGAL's exude_mesh_3 with a limit of turns. Where points lie in planes, as in a thin slab, CGAL takes the
/// same slivers from one point to another and back for ever. Other meshes need about one turn a tet.
void exude(Complex& complex, const std::function<void()>& turn) {
  constexpr std::size_t turns_per_tet = 5;
  using Angle = CGAL::Mesh_3::Min_dihedral_angle_criterion<Triangulation>;
  std::size_t left = turns_per_tet * complex.number_of_cells_in_complex();
  CGAL::Mesh_3::Slivers_exuder<Complex, Angle, TurnsLeft> exuder(complex,
                                                                 Angle(0.0, complex.triangulation()));
  try {
    exuder({&left, &turn});
  } catch (const ExuderIsDone&) {
    // What it has done so far is kept.
  }
}

}  // namespace

std::optional<LabelledMesh> mesh_domain(const LabelledDomain& domain, const MeshingCriteria& criteria) {
  if (domain.seeds.empty()) return LabelledMesh{};
  CGAL::set_warning_handler([](const char*, const char*, const char*, int, const char*) {
  });  // replaces CGAL's function, which prints
  CGAL::set_error_handler([](const char*, const char*, const char*, int, const char*) {});
  int turns = 0;
  const std::function<void()> turn = [&] {
    constexpr int turns_between = 1024;
    if (++turns % turns_between == 0 && criteria.check) criteria.check();
  };
  const CgalDomain labelled = make_domain(domain, turn);
  const Criteria fine(parameters::facet_angle = 25.0, parameters::facet_size = CgalSize{&criteria.facet_size},
                      parameters::facet_distance = CgalSize{&criteria.facet_distance},
                      parameters::cell_radius_edge_ratio = 2.5,
                      parameters::cell_size = CgalSize{&criteria.cell_size});
  for (const bool manifold : {true, false}) {
    if (manifold && !criteria.manifold) continue;
    CGAL::get_default_random() = CGAL::Random(0);  // CGAL draws from it when it perturbs points
    std::optional<Complex> complex = refined(labelled, domain, fine, criteria.max_points, manifold);
    if (!complex) continue;
    if (!criteria.wanted || criteria.wanted(complex->number_of_cells_in_complex())) {
      // No limits of time: the mesh must not depend on the machine.
      CGAL::perturb_mesh_3(*complex, labelled);
      exude(*complex, turn);
    }
    return sorted_mesh(*complex, manifold);
  }
  return std::nullopt;
}

}  // namespace palpate::app
