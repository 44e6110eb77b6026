#include "organ_mesher.hpp"

// CGAL's mesher: it takes half a minute and 3 GB to compile.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

namespace palpate::app {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using LabeledDomain = CGAL::Labeled_mesh_domain_3<Kernel>;

/// The domain of CGAL, but the surface is followed from our seeds: CGAL's own are where random rays meet it,
/// and miss small components.
class OrganDomain : public LabeledDomain {
 public:
  OrganDomain(const LabeledDomain& domain, const std::vector<Vec3>& seeds)
      : LabeledDomain(domain), seeds_(&seeds) {}

  struct Construct_initial_points {  // NOLINT(readability-identifier-naming): CGAL looks for this name
    const OrganDomain* domain;
    template <class Output>
    Output operator()(Output output, int /*count*/ = 0) const {
      const auto index = domain->index_from_surface_patch_index({0, 1});
      for (const Vec3& seed : *domain->seeds_) *output++ = {Point_3(seed.x, seed.y, seed.z), index};
      return output;
    }
  };
  [[nodiscard]] Construct_initial_points construct_initial_points_object() const { return {this}; }

 private:
  const std::vector<Vec3>* seeds_;
};

using Triangulation = CGAL::Mesh_triangulation_3<OrganDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace parameters = CGAL::parameters;

}  // namespace
}  // namespace palpate::app

/// CGAL would write files into the current folder where its refinement fails.
template <>
struct CGAL::Dump_c3t3<palpate::app::Complex, true> {  // NOLINT(readability-identifier-naming)
  void dump_c3t3(const palpate::app::Complex& /*complex*/, const std::string& /*prefix*/) const {}
};

namespace palpate::app {
namespace {

OrganDomain make_domain(const ImplicitOrgan& organ) {
  const auto is_inside = [&organ](const Kernel::Point_3& p) {
    return organ.field({p.x(), p.y(), p.z()}) > 0.0 ? 1 : 0;
  };
  const CGAL::Bbox_3 box(organ.lower.x, organ.lower.y, organ.lower.z, organ.upper.x, organ.upper.y,
                         organ.upper.z);
  return {LabeledDomain(is_inside, box, parameters::relative_error_bound = 1e-4), organ.seeds};
}

/// Points and tets in an order that does not depend on where CGAL has them in memory.
TetMesh sorted_mesh(const Complex& complex) {
  const auto place = [](const auto& vertex) {
    const auto& p = vertex->point();
    return std::tuple(p.x(), p.y(), p.z());
  };
  std::map<std::tuple<double, double, double>, Index> points;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    for (int i = 0; i < 4; ++i) points.try_emplace(place(cell->vertex(i)), 0);
  }
  TetMesh mesh;
  for (auto& [point, index] : points) {
    index = static_cast<Index>(mesh.points.size());
    mesh.points.push_back({std::get<0>(point), std::get<1>(point), std::get<2>(point)});
  }
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tet tet{};
    for (int i = 0; i < 4; ++i) tet[static_cast<std::size_t>(i)] = points.at(place(cell->vertex(i)));
    // Even turns bring the lowest corner to the front and keep the volume positive.
    const auto lowest = std::ranges::min_element(tet) - tet.begin();
    if (lowest == 1) tet = {tet[1], tet[0], tet[3], tet[2]};
    if (lowest == 2) tet = {tet[2], tet[3], tet[0], tet[1]};
    if (lowest == 3) tet = {tet[3], tet[2], tet[1], tet[0]};
    while (tet[1] > tet[2] || tet[1] > tet[3]) tet = {tet[0], tet[2], tet[3], tet[1]};
    mesh.tets.push_back(tet);
  }
  std::ranges::sort(mesh.tets);
  return mesh;
}

}  // namespace

namespace {

/// Refined to the criteria; none where that takes more points, or CGAL meets a case it has no answer for.
std::optional<Complex> refined(const OrganDomain& domain, const Criteria& criteria, std::size_t max_points,
                               bool manifold) {
  CGAL::Mesh_error_code failed = CGAL::CGAL_MESH_3_NO_ERROR;
  try {
    auto complex = CGAL::make_mesh_3<Complex>(
        domain, criteria, parameters::no_perturb(), parameters::no_exude(),
        manifold ? parameters::manifold() : parameters::non_manifold(),
        parameters::mesh_3_options(parameters::maximal_number_of_vertices = max_points,
                                   parameters::pointer_to_error_code = &failed));
    if (failed == CGAL::CGAL_MESH_3_NO_ERROR) return complex;
  } catch (const CGAL::Failure_exception&) {
    // Mostly a point that is asked for twice, where the surface is no manifold.
  }
  return std::nullopt;
}

}  // namespace

std::optional<OrganMesh> mesh_organ(const ImplicitOrgan& organ, const MeshingCriteria& criteria) {
  if (organ.seeds.empty()) return OrganMesh{};
  CGAL::set_warning_handler([](const char*, const char*, const char*, int, const char*) {});  // it prints
  CGAL::set_error_handler([](const char*, const char*, const char*, int, const char*) {});
  const OrganDomain domain = make_domain(organ);
  const Criteria fine(parameters::facet_angle = 25.0, parameters::facet_size = criteria.facet_size,
                      parameters::facet_distance = criteria.facet_distance,
                      parameters::cell_radius_edge_ratio = 2.5, parameters::cell_size = criteria.cell_size);
  for (const bool manifold : {true, false}) {
    CGAL::get_default_random() = CGAL::Random(0);  // perturbing draws from it
    std::optional<Complex> complex = refined(domain, fine, criteria.max_points, manifold);
    if (!complex) continue;
    // No limit of time: the mesh must not depend on the machine.
    CGAL::perturb_mesh_3(*complex, domain);
    CGAL::exude_mesh_3(*complex);
    return OrganMesh{sorted_mesh(*complex), manifold};
  }
  return std::nullopt;
}

}  // namespace palpate::app
