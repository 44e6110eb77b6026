#include "fem/smoothing_domains.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "fem/volume_patches.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr auto& edges = SmoothedTet::edges;

/// The part of a domain that is in one tet, with the edge or point of the domain.
struct Part {
  Index first = 0;
  Index second = 0;  ///< for a point: equal to `first`
  Index material = 0;
  std::uint32_t tet = 0;
  std::uint32_t place = 0;
};

bool same_domain(const Part& a, const Part& b) {
  return a.first == b.first && a.second == b.second && a.material == b.material;
}

enum class DomainKind : std::uint8_t { edge, point, patch };

void add_patch_parts(std::span<const SmoothedTet> tets, std::vector<Part>& parts) {
  std::vector<PatchTet> of_patches;
  std::vector<std::uint32_t> places;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (tets[t].patch_lambda() == 0.0) continue;
    of_patches.push_back({tets[t].corners, tets[t].material});
    places.push_back(static_cast<std::uint32_t>(t));
  }
  const std::vector<std::uint32_t> patches = volume_patches(of_patches);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const auto patch = static_cast<Index>(patches[k]);
    parts.push_back({patch, patch, of_patches[k].material, places[k], SmoothedTet::patch_place});
  }
}

/// The parts of all domains of a kind, sorted by domain.
std::vector<Part> list_parts(std::span<const SmoothedTet> tets, DomainKind kind) {
  std::vector<Part> parts;
  if (kind == DomainKind::patch) add_patch_parts(tets, parts);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const auto add = [&](std::size_t a, std::size_t b, std::size_t place) {
      const auto [first, second] = std::minmax(tets[t].corners[a], tets[t].corners[b]);
      parts.push_back({first, second, tets[t].material, static_cast<std::uint32_t>(t),
                       static_cast<std::uint32_t>(place)});
    };
    if (kind == DomainKind::edge) {
      for (std::size_t k = 0; k < edges.size(); ++k) add(edges[k][0], edges[k][1], k);
    } else if (kind == DomainKind::point && tets[t].lambda != 0.0) {
      for (std::size_t k = 0; k < 4; ++k) add(k, k, edges.size() + k);
    }
  }
  const auto key = [](const Part& p) { return std::tuple(p.first, p.second, p.material, p.tet); };
  std::ranges::sort(parts, {}, key);
  return parts;
}

}  // namespace

SmoothingDomains::SmoothingDomains(std::vector<SmoothedTet> tets, std::size_t point_count,
                                   std::span<const Material> materials)
    : tets_(std::move(tets)) {
  constexpr std::uint32_t none = 0xffffffffU;
  domain_of_tet_.assign(domains_of_tet * tets_.size(), none);
  std::vector<Member> members;
  for (const DomainKind kind : {DomainKind::edge, DomainKind::point, DomainKind::patch}) {
    if (kind == DomainKind::point) volume_begin_ = size();
    patch_begin_ = size();
    const std::vector<Part> parts = list_parts(tets_, kind);
    for (std::size_t first = 0; first < parts.size();) {
      members.clear();
      std::size_t last = first;
      for (; last < parts.size() && same_domain(parts[first], parts[last]); ++last)
        members.push_back({parts[last].tet, parts[last].place});
      add_domain(members);
      first = last;
    }
  }
  list_entries(point_count);
  std::vector<Index> material(size());
  for (std::size_t d = 0; d < size(); ++d) material[d] = first_tet(d).material;
  viscosity_ = ViscousElements(materials, material);
  elastic_fractions_.assign(size(), 1.0);
  ambient_.assign(size(), 0.0);
  stresses_.resize(size());
  densities_.resize(size());
  scales_.resize(size());
  rotations_.resize(size());
  twist_stiffness_.resize(size());
  rotated_.resize(points_.size());
  const bool hyperelastic = std::ranges::any_of(tets_, &SmoothedTet::hyperelastic);
  const bool fibres =
      std::ranges::any_of(laws_, [](const HyperelasticLaw& law) { return law.fibre != Vec3{}; });
  if (hyperelastic) tangents_.resize(size(), fibres);
  changes_.resize(size());
}

void SmoothingDomains::add_domain(std::span<const Member> members) {
  const auto domain = static_cast<std::uint32_t>(size());
  const double fraction = volume_fraction(members.front().place);
  double volume = 0.0;
  const std::size_t first = points_.size();
  for (const Member& m : members) {
    const SmoothedTet& tet = tets_[m.tet];
    volume += fraction * tet.volume;
    points_.insert(points_.end(), tet.corners.begin(), tet.corners.end());
    domain_of_tet_[domains_of_tet * m.tet + m.place] = domain;
  }
  const auto own = points_.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(own, points_.end());
  points_.erase(std::unique(own, points_.end()), points_.end());
  rest_gradients_.resize(points_.size());
  for (const Member& m : members) {
    const SmoothedTet& tet = tets_[m.tet];
    for (std::size_t k = 0; k < 4; ++k) {
      const auto place = std::lower_bound(own, points_.end(), tet.corners[k]) - points_.begin();
      rest_gradients_[static_cast<std::size_t>(place)] += (fraction * tet.volume / volume) * tet.gradients[k];
    }
  }
  volume_.push_back(volume);
  begin_.push_back(static_cast<std::uint32_t>(points_.size()));
  for (const Member& m : members) domain_tets_.push_back(m.tet);
  tet_begin_.push_back(static_cast<std::uint32_t>(domain_tets_.size()));
  set_law(members);
}

/// Sets the law of a domain: that of its material, with fibres along the mean line of its tets.
void SmoothingDomains::set_law(std::span<const Member> members) {
  HyperelasticLaw law = tets_[members.front().tet].law;
  Vec3 sum;
  for (const Member& m : members) {
    const SmoothedTet& tet = tets_[m.tet];
    sum += (dot(tet.law.fibre, law.fibre) < 0.0 ? -tet.volume : tet.volume) * tet.law.fibre;
  }
  const double size = length(sum);
  if (size > 0.0) law.fibre = (1.0 / size) * sum;
  laws_.push_back(law);
}

void SmoothingDomains::list_entries(std::size_t point_count) {
  entry_begin_.assign(point_count + 1, 0);
  for (const Index point : points_) ++entry_begin_[static_cast<std::size_t>(point) + 1];
  for (std::size_t i = 0; i < point_count; ++i) {
    if (entry_begin_[i + 1] != 0) smoothed_points_.push_back(static_cast<Index>(i));
    entry_begin_[i + 1] += entry_begin_[i];
  }
  entries_.resize(points_.size());
  std::vector<std::size_t> next(entry_begin_.begin(), entry_begin_.end() - 1);
  for (std::size_t d = 0; d < size(); ++d) {
    for (std::size_t k = 0; k < points(d).size(); ++k) {
      entries_[next[static_cast<std::size_t>(points(d)[k])]++] = {static_cast<std::uint32_t>(d),
                                                                  static_cast<std::uint32_t>(k)};
    }
  }
}

std::span<const SmoothingDomains::Entry> SmoothingDomains::entries(Index point) const {
  if (entry_begin_.empty()) return {};
  const std::size_t first = first_entry(point);
  return std::span(entries_).subspan(first, entry_begin_[static_cast<std::size_t>(point) + 1] - first);
}

}  // namespace palpate::fem
