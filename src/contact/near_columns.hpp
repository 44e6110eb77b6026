#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <palpate/types.hpp>

#include "contact/cluster_pairs.hpp"
#include "contact/near_edges.hpp"
#include "room.hpp"
#include "simd/cluster_motions.hpp"

namespace palpate {

/// Pairs of clusters of two bodies that may be near each other, in columns that kernels read. Each pair has a
/// list of its near edges, complete until the two clusters have come nearer to each other by `room`.
struct ClusterGroups {
  std::vector<Index> first;
  std::vector<Index> second;
  std::vector<float> usual;  ///< relative motion per detection: the last, or half of the one before, m
  std::vector<float> moved;  ///< bound of the relative motion since it was listed, m
  std::vector<float> room;   ///< m; negative: there is no list
  std::vector<float> apart;  ///< motion from which on a pair of the list must be tested again, m
  std::vector<std::uint32_t> begin;  ///< of the list, in NearEdges
  std::vector<std::uint32_t> listed;

  [[nodiscard]] std::size_t size() const { return first.size(); }
  [[nodiscard]] IndexPair clusters(std::size_t i) const { return {first[i], second[i]}; }
  [[nodiscard]] bool is_listed(std::size_t i) const { return moved[i] <= room[i]; }
  [[nodiscard]] simd::MovingPairs moving() {
    return {first.data(), second.data(), usual.data(), moved.data(), room.data(), apart.data()};
  }
  void resize(std::size_t size) {
    for_each_column([&](auto& column, auto) { resize_with_room(column, size); });
  }
  void set(std::size_t i, const IndexPair& clusters) {
    first[i] = clusters.first;
    second[i] = clusters.second;
    usual[i] = moved[i] = apart[i] = 0.0F;
    room[i] = -1.0F;
    begin[i] = listed[i] = 0;
  }
  /// \param from  row of another table
  void set(std::size_t i, const ClusterGroups& other, std::size_t from) {
    for_each_column([&](auto& column, auto member) { column[i] = (other.*member)[from]; });
  }
  void copy(const ClusterGroups& other) {
    for_each_column([&](auto& column, auto member) {
      const auto& from = other.*member;
      make_room(column, from.size());
      column.assign(from.begin(), from.end());
    });
  }

 private:
  template <class Use>
  void for_each_column(Use&& use) {
    using G = ClusterGroups;
    std::apply(
        [&](auto... member) { (use(this->*member, member), ...); },
        std::tuple(&G::first, &G::second, &G::usual, &G::moved, &G::room, &G::apart, &G::begin, &G::listed));
  }
};

/// The lists of all pairs of clusters, one after the other, in columns.
class NearEdges {
 public:
  std::vector<Index> edge;
  std::vector<Index> triangle;
  /// Bound of the distance when tested, and the motion of the clusters from the list until then, m: they are
  /// to be tested again when the clusters have moved so far. 0: they may meet.
  std::vector<float> apart;

  /// The columns are longer.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool has_room(std::size_t size) const { return size_ + size <= edge.size(); }
  void make_room(std::size_t size) {
    edge.resize(size);
    triangle.resize(size);
    apart.resize(size);
  }
  void clear() { size_ = 0; }
  /// Adds items without values, only where there is room.
  void grow(std::size_t size) { size_ += size; }
  /// Sets items from number `begin` on.
  void put(std::size_t begin, std::span<const NearEdge> list) {
    for (const NearEdge& near : list) {
      edge[begin] = near.pair.edge;
      triangle[begin] = near.pair.triangle;
      apart[begin++] = near.apart;
    }
  }
  void append(const NearEdges& other, std::size_t begin, std::size_t size) {
    for (std::size_t i = begin; i < begin + size; ++i) {
      edge[size_] = other.edge[i];
      triangle[size_] = other.triangle[i];
      apart[size_++] = other.apart[i];
    }
  }
  void swap(NearEdges& other) noexcept {
    edge.swap(other.edge);
    triangle.swap(other.triangle);
    apart.swap(other.apart);
    std::swap(size_, other.size_);
  }

 private:
  std::size_t size_ = 0;
};

}  // namespace palpate
