#pragma once

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "geometry/axis.hpp"
#include "geometry/box.hpp"

namespace palpate {

/// Squared distance of two boxes; 0 where they overlap.
inline double squared_distance(const Box& a, const Box& b) {
  const auto gap = [&](double Vec3::*axis) {
    return std::max({0.0, a.lower.*axis - b.upper.*axis, b.lower.*axis - a.upper.*axis});
  };
  return squared_length(Vec3{gap(&Vec3::x), gap(&Vec3::y), gap(&Vec3::z)});
}

/// A binary tree of boxes, split at the median of their centres along the longest side.
class BoxTree {
 public:
  /// O(n log n).
  explicit BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    if (!order_.empty()) build(0, order_.size());
  }

  /// Calls visit(i) for each box i whose squared distance may be below within(). within() is called again for
  /// each node, so visit() may reduce it. Nearer nodes come first.
  template <class Within, class Visit>
  void for_each_within(const Box& box, Within&& within, Visit&& visit) const {
    if (!nodes_.empty()) walk(0, box, within, visit);
  }

 private:
  static constexpr std::size_t leaf = 8;
  struct Node {
    Box box;
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t second = 0;  ///< index of the second child; the first child is the next node. 0: a leaf
  };

  std::size_t build(std::size_t begin, std::size_t end) {
    const std::size_t number = nodes_.size();
    nodes_.push_back({.box = {}, .begin = begin, .end = end});
    for (std::size_t i = begin; i < end; ++i) nodes_[number].box.extend(boxes_[order_[i]]);
    if (end - begin <= leaf) return number;
    const Vec3 size = nodes_[number].box.upper - nodes_[number].box.lower;
    const std::size_t axis = longest_axis(size);
    const auto key = [&](std::size_t i) {
      return along(axis, boxes_[i].lower) + along(axis, boxes_[i].upper);
    };
    const std::size_t middle = begin + (end - begin) / 2;
    const auto place = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(place(begin), place(middle), place(end), [&](std::size_t a, std::size_t b) {
      return key(a) != key(b) ? key(a) < key(b) : a < b;
    });
    build(begin, middle);
    const std::size_t second = build(middle, end);
    nodes_[number].second = second;
    return number;
  }

  template <class Within, class Visit>
  void walk(std::size_t number, const Box& box, Within& within, Visit& visit) const {
    const Node& node = nodes_[number];
    const auto near = [&](const Box& other) {
      const double reach = within();
      return squared_distance(box, other) <= reach * reach;
    };
    if (!near(node.box)) return;
    if (node.second == 0) {
      for (std::size_t i = node.begin; i < node.end; ++i)
        if (near(boxes_[order_[i]])) visit(order_[i]);
      return;
    }
    std::size_t first = number + 1;
    std::size_t second = node.second;
    if (squared_distance(box, nodes_[second].box) < squared_distance(box, nodes_[first].box))
      std::swap(first, second);
    walk(first, box, within, visit);
    walk(second, box, within, visit);
  }

  std::vector<Box> boxes_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace palpate
