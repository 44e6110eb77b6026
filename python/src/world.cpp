#include "world.hpp"

#include <algorithm>
#include <nanobind/nanobind.h>
#include <numeric>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"

namespace palpate::python {

Index World::add(std::string name, TetMesh mesh, bool movable, bool self_collision) {
  const Busy::Use use(busy_, "World.add");
  check_name(*bodies_, name, "World.add");
  const std::vector<Tet> given = mesh.tets;
  // Arrays that Python still holds keep their bodies alive, so bodies are copied then.
  auto bodies = bodies_.use_count() == 1 && !detector_ ? bodies_ : std::make_shared<Bodies>(*bodies_);
  const Index body = bodies->add(std::move(name), std::move(mesh));
  clear_results();
  detector_.reset();
  bodies_ = std::move(bodies);
  immovable_.push_back(movable ? 0 : 1);
  settings_.self_collision.push_back(self_collision ? 1 : 0);
  const std::vector<std::uint8_t> flags = reoriented_tets(given, *bodies_, body);
  reoriented_.insert(reoriented_.end(), flags.begin(), flags.end());
  return body;
}

void World::set_ignored_pairs(std::vector<std::array<Index, 2>> pairs) {
  const Busy::Use use(busy_, "World.set_pair_filter");
  DetectionSettings settings = settings_;
  settings.ignored_pairs = std::move(pairs);
  auto detector = std::make_unique<Detector>(*bodies_, settings, immovable_, threads_);
  clear_results();
  settings_ = std::move(settings);
  detector_ = std::move(detector);
}

void World::update(std::span<const Vec3> positions) {
  const Busy::Use use(busy_, "World.update");
  const nanobind::gil_scoped_release release;
  if (!detector_) detector_ = std::make_unique<Detector>(*bodies_, settings_, immovable_, threads_);
  detector_->detect(positions);
  clear_results();
  has_results_ = true;
}

void World::clear_results() {
  has_results_ = false;
  contacts_.reset();
  crossings_.reset();
}

const Detector& World::updated() const {
  busy_.check("World");
  if (!has_results_) {
    throw Error("World", "", "that update() was not called for these bodies",
                "a call of update(positions) before this one");
  }
  return *detector_;
}

std::shared_ptr<const Contacts> World::contacts() {
  busy_.check("World");
  if (!contacts_) {
    static_cast<void>(updated());
    contacts_ = std::make_shared<Contacts>(detector_->take_contacts());
    order_weights_as_given(*contacts_, reoriented_);
  }
  return contacts_;
}

std::shared_ptr<const Crossings> World::crossings() {
  if (!crossings_) crossings_ = std::make_shared<Crossings>(crossings_of(updated()));
  return crossings_;
}

EdgeContacts World::edge_contacts() const {
  return updated().edge_contacts();
}
DetectionCounts World::stats() const {
  return updated().counts();
}
DetectionTimes World::times() const {
  return updated().times();
}
std::vector<std::uint8_t> World::late_bodies() const {
  const std::span<const std::uint8_t> late = updated().late_bodies();
  return {late.begin(), late.end()};
}
std::size_t World::structure_bytes() const {
  return updated().structure_bytes();
}

Crossings crossings_of(const Detector& detector) {
  Crossings result;
  for (const Crossing& crossing : detector.crossings()) {
    const BorderEdge& edge = at(detector.border_edges(), crossing.border_edge);
    result.contact.push_back(edge.contact);
    result.free_point.push_back(edge.free_point);
    result.triangle.push_back(crossing.triangle);
    result.parameter.push_back(crossing.parameter);
  }
  return result;
}

void check_name(const Bodies& bodies, const std::string& name, const char* what) {
  if (name.empty()) throw Error(what, "name", "an empty text", "a text that is not empty");
  if (name.find('\0') != std::string::npos) throw Error(what, "name", "a NUL character", "a text without it");
  if (std::ranges::find(bodies.bodies(), name, &Body::name) != bodies.bodies().end())
    throw Error(what, "name", "'" + name + "' for the second time", "a name that no other body has");
}

std::vector<std::uint8_t> reoriented_tets(std::span<const Tet> given, const Bodies& bodies, Index body) {
  const auto& [points, tets] = std::pair{at(bodies.bodies(), body).points, at(bodies.bodies(), body).tets};
  std::vector<std::uint8_t> reoriented;
  reoriented.reserve(given.size());
  for (Index t = 0; t < tets.size(); ++t) {
    // In a reordered tet, the third and the fourth corner are swapped, so the third tells.
    reoriented.push_back(at(bodies.tets(), tets.begin + t)[2] - points.begin == at(given, t)[2] ? 0 : 1);
  }
  return reoriented;
}

void order_weights_as_given(Contacts& contacts, std::span<const std::uint8_t> reoriented) {
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (at(reoriented, contacts.tet[c]) != 0) std::swap(contacts.weights[c][2], contacts.weights[c][3]);
  }
}

Contacts renumbered(const Contacts& contacts, std::span<const Index> points, std::span<const Index> tets,
                    std::span<const Index> bodies) {
  const auto in = [](std::span<const Index> numbers, Index old) {
    if (static_cast<std::size_t>(old) < numbers.size()) return at(numbers, old);
    throw Error("renumbered", "", "no new number for index " + std::to_string(old),
                "a new number for each index");
  };
  std::vector<std::size_t> order(contacts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t c) {
    return std::pair(in(points, contacts.point[c]), in(bodies, contacts.body[c]));
  });
  Contacts result;
  for (const std::size_t c : order) {
    result.point.push_back(in(points, contacts.point[c]));
    result.body.push_back(in(bodies, contacts.body[c]));
    result.tet.push_back(in(tets, contacts.tet[c]));
    result.weights.push_back(contacts.weights[c]);
    result.depth.push_back(contacts.depth[c]);
    result.direction.push_back(contacts.direction[c]);
    result.certainty.push_back(contacts.certainty[c]);
  }
  return result;
}

}  // namespace palpate::python
