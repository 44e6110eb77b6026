#include "fem/transfer.hpp"

#include <algorithm>
#include <cmath>

#include "fem/block_products.hpp"
#include "fem/matrix.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t transfer_node_grain = 256;
constexpr int sweeps = 2;

}  // namespace

template <std::size_t N, std::size_t M>
BlockRows<M, N> transposed(const BlockRows<N, M>& rows, std::size_t count) {
  const ColumnLists lists = columns_of(rows, count);
  BlockRows<M, N> result{lists.begin, lists.rows, std::vector<Dense<M, N>>(lists.blocks.size())};
  for (std::size_t place = 0; place < lists.blocks.size(); ++place) {
    const Dense<N, M>& block = rows.blocks[lists.blocks[place]];
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < M; ++j) result.blocks[place][N * j + i] = block[M * i + j];
    }
  }
  return result;
}

template <std::size_t N>
Dense<N, 6> rigid_motion(const Node& part, const Node& whole) {
  const Vec3 d = part.middle - whole.middle;
  const double inverse = whole.radius > 0.0 ? 1.0 / whole.radius : 0.0;
  Dense<N, 6> motion{};
  for (std::size_t k = 0; k < 3; ++k) motion[7 * k] = 1.0;
  motion[4] = inverse * d.z;
  motion[5] = -inverse * d.y;
  motion[9] = -inverse * d.z;
  motion[11] = inverse * d.x;
  motion[15] = inverse * d.y;
  motion[16] = -inverse * d.x;
  if constexpr (N == 6) {
    for (std::size_t k = 3; k < 6; ++k) motion[7 * k] = inverse * part.radius;
  }
  return motion;
}

namespace {

template <std::size_t N>
class Minimiser {
 public:
  Minimiser(const parallel::Threads& threads, const BlockRows<N, N>& a, const NodeGraph& graph,
            std::span<const Node> nodes, std::span<const Index> aggregate_of_node,
            std::span<const Node> aggregates)
      : threads_(threads),
        a_(a),
        graph_(graph),
        nodes_(nodes),
        of_(aggregate_of_node),
        aggregates_(aggregates) {}

  BlockRows<N, 6> run() {
    start();
    const std::size_t count = nodes_.size();
    std::vector<Block> residual(transfer_.blocks.size());
    std::vector<Block> direction(residual.size());
    std::vector<Block> product(residual.size());
    multiply(transfer_.blocks, residual, true);
    for (Block& block : residual) {
      for (double& value : block) value = -value;
    }
    Index bodies = 0;
    for (const Node& node : nodes_) bodies = std::max(bodies, node.body + 1);
    std::vector<double> before(static_cast<std::size_t>(bodies), 0.0);
    std::vector<double> partial(count);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for_each_node([&](std::size_t i) {
        double sum = 0.0;
        for_each_block(i, [&](std::size_t k) {
          Block z{};
          add_product<N, N, 6>(z, inverse_diagonal_[i], residual[k]);
          product[k] = z;
          for (std::size_t e = 0; e < z.size(); ++e) sum += z[e] * residual[k][e];
        });
        partial[i] = sum;
      });
      const std::vector<double> now = by_body(partial, before.size());
      for_each_node([&](std::size_t i) {
        const double old = at(before, nodes_[i].body);
        const double beta = old > 0.0 ? at(now, nodes_[i].body) / old : 0.0;
        for_each_block(i, [&](std::size_t k) {
          for (std::size_t e = 0; e < 6 * N; ++e) direction[k][e] = product[k][e] + beta * direction[k][e];
        });
      });
      before = now;
      multiply(direction, product);
      for_each_node([&](std::size_t i) {
        double sum = 0.0;
        for_each_block(i, [&](std::size_t k) {
          for (std::size_t e = 0; e < 6 * N; ++e) sum += direction[k][e] * product[k][e];
        });
        partial[i] = sum;
      });
      const std::vector<double> curvature = by_body(partial, before.size());
      for_each_node([&](std::size_t i) {
        const double below = at(curvature, nodes_[i].body);
        const double step = below > 0.0 ? at(now, nodes_[i].body) / below : 0.0;
        for_each_block(i, [&](std::size_t k) {
          for (std::size_t e = 0; e < 6 * N; ++e) {
            transfer_.blocks[k][e] += step * direction[k][e];
            residual[k][e] -= step * product[k][e];
          }
        });
      });
    }
    return std::move(transfer_);
  }

 private:
  using Block = Dense<N, 6>;

  template <class Body>
  void for_each_node(Body&& body) {
    parallel::for_each(threads_, nodes_.size(), transfer_node_grain, body);
  }
  template <class Body>
  void for_each_block(std::size_t i, Body&& body) {
    for (std::size_t k = transfer_.begin[i]; k < transfer_.begin[i + 1]; ++k) body(k);
  }

  /// Starts with the sparsity pattern, and the rigid motions of each aggregate.
  void start() {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const std::size_t first = transfer_.columns.size();
      for (std::uint32_t k = graph_.begin[i]; k < graph_.begin[i + 1]; ++k)
        transfer_.columns.push_back(static_cast<std::uint32_t>(of_[graph_.columns[k]]));
      const auto own = transfer_.columns.begin() + static_cast<std::ptrdiff_t>(first);
      std::sort(own, transfer_.columns.end());
      transfer_.columns.erase(std::unique(own, transfer_.columns.end()), transfer_.columns.end());
      transfer_.begin.push_back(static_cast<std::uint32_t>(transfer_.columns.size()));
    }
    transfer_.blocks.assign(transfer_.columns.size(), {});
    inverse_diagonal_.resize(nodes_.size());
    inverse_squares_.resize(nodes_.size());
    for_each_node([&](std::size_t i) {
      for_each_block(i, [&](std::size_t k) {
        if (transfer_.columns[k] == static_cast<std::uint32_t>(of_[i]))
          transfer_.blocks[k] = rigid_motion<N>(nodes_[i], at(aggregates_, of_[i]));
      });
      for (std::uint32_t k = a_.begin[i]; k < a_.begin[i + 1]; ++k) {
        if (a_.columns[k] == i) inverse_diagonal_[i] = inverse_semi_definite<N>(a_.blocks[k]);
      }
      inverse_squares_[i] = inverse_squares(i);
    });
  }

  /// y = A x, restricted to the pattern and projected so that rigid motions are still reproduced.
  /// \param own_only  x is zero but for the block of each node's own aggregate
  void multiply(const std::vector<Block>& x, std::vector<Block>& y, bool own_only = false) {
    parallel::for_chunks(
        threads_, nodes_.size(), transfer_node_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
          std::vector<simd::BlockPair> pairs;
          for (std::size_t i = begin; i < end; ++i) {
            for_each_block(i, [&](std::size_t k) { y[k] = {}; });
            list_pairs(i, own_only, pairs);
            constexpr auto kind = N == 3 ? simd::BlockProduct::three : simd::BlockProduct::six;
            add_products(kind, a_.blocks, x, pairs, std::span(y));
            project(i, y);
          }
        });
  }

  /// The products of blocks that make a row of A x.
  void list_pairs(std::size_t i, bool own_only, std::vector<simd::BlockPair>& pairs) {
    pairs.clear();
    const std::uint32_t last = transfer_.begin[i + 1];
    for (std::uint32_t e = a_.begin[i]; e < a_.begin[i + 1]; ++e) {
      const std::uint32_t j = a_.columns[e];
      std::uint32_t place = transfer_.begin[i];
      for (std::uint32_t k = transfer_.begin[j]; k < transfer_.begin[j + 1]; ++k) {
        const std::uint32_t column = transfer_.columns[k];
        if (own_only && column != static_cast<std::uint32_t>(of_[j])) continue;
        while (place < last && transfer_.columns[place] < column) ++place;  // both lists ascend
        if (place < last && transfer_.columns[place] == column) pairs.push_back({e, k, place});
      }
    }
  }

  /// The node with the radius of its aggregate: the frame in which project() describes rigid motions.
  [[nodiscard]] Node frame_of(std::size_t i) const {
    Node here = at(aggregates_, of_[i]);
    here.middle = nodes_[i].middle;
    if (here.radius == 0.0) here.radius = 1.0;
    return here;
  }

  /// Inverse of the sum of M^T M over the aggregates of a node, with their rigid motions M.
  [[nodiscard]] Dense<6, 6> inverse_squares(std::size_t i) {
    const Node here = frame_of(i);
    Dense<6, 6> squares{};
    for_each_block(i, [&](std::size_t k) {
      const Dense<6, 6> motion = rigid_motion<6>(aggregates_[transfer_.columns[k]], here);
      add_transposed_product<6, 6, 6>(squares, motion, motion);
    });
    return inverse_semi_definite<6>(squares);
  }

  /// Projects a row so that it has no effect on rigid motions.
  void project(std::size_t i, std::vector<Block>& y) {
    const Node here = frame_of(i);
    Dense<N, 6> moved{};
    for_each_block(i, [&](std::size_t k) {
      const Dense<6, 6> m = rigid_motion<6>(aggregates_[transfer_.columns[k]], here);
      for (std::size_t r = 0; r < N; ++r) {  // moved += y m, without the zeros of m
        const double* v = &y[k][6 * r];
        double* sum = &moved[6 * r];
        for (std::size_t e = 0; e < 3; ++e) sum[e] += v[e];
        sum[3] += v[1] * m[9] + v[2] * m[15] + v[3] * m[21];
        sum[4] += v[0] * m[4] + v[2] * m[16] + v[4] * m[28];
        sum[5] += v[0] * m[5] + v[1] * m[11] + v[5] * m[35];
      }
    });
    Dense<N, 6> coefficients{};
    add_product<N, 6, 6>(coefficients, moved, inverse_squares_[i]);
    for_each_block(i, [&](std::size_t k) {
      const Dense<6, 6> m = rigid_motion<6>(aggregates_[transfer_.columns[k]], here);
      for (std::size_t r = 0; r < N; ++r) {  // y -= coefficients m^T
        const double* c = &coefficients[6 * r];
        double* v = &y[k][6 * r];
        v[0] -= c[0] + c[4] * m[4] + c[5] * m[5];
        v[1] -= c[1] + c[3] * m[9] + c[5] * m[11];
        v[2] -= c[2] + c[3] * m[15] + c[4] * m[16];
        for (std::size_t e = 3; e < 6; ++e) v[e] -= c[e] * m[7 * e];
      }
    });
  }

  std::vector<double> by_body(const std::vector<double>& partial, std::size_t bodies) {
    std::vector<double> sums(bodies, 0.0);
    for (std::size_t i = 0; i < partial.size(); ++i) at(sums, nodes_[i].body) += partial[i];
    return sums;
  }

  const parallel::Threads& threads_;
  const BlockRows<N, N>& a_;
  NodeGraph graph_;
  std::span<const Node> nodes_;
  std::span<const Index> of_;
  std::span<const Node> aggregates_;
  BlockRows<N, 6> transfer_;
  std::vector<Dense<N, N>> inverse_diagonal_;
  std::vector<Dense<6, 6>> inverse_squares_;
};

}  // namespace

template <std::size_t N>
BlockRows<N, 6> least_energy_transfer(const parallel::Threads& threads, const BlockRows<N, N>& a,
                                      const NodeGraph& graph, std::span<const Node> nodes,
                                      std::span<const Index> aggregate_of_node,
                                      std::span<const Node> aggregates) {
  return Minimiser<N>(threads, a, graph, nodes, aggregate_of_node, aggregates).run();
}

template Dense<3, 6> rigid_motion<3>(const Node&, const Node&);
template Dense<6, 6> rigid_motion<6>(const Node&, const Node&);
template BlockRows<6, 3> transposed(const BlockRows<3, 6>&, std::size_t);
template BlockRows<6, 6> transposed(const BlockRows<6, 6>&, std::size_t);
template BlockRows<3, 6> least_energy_transfer(const parallel::Threads&, const BlockRows<3, 3>&,
                                               const NodeGraph&, std::span<const Node>,
                                               std::span<const Index>, std::span<const Node>);
template BlockRows<6, 6> least_energy_transfer(const parallel::Threads&, const BlockRows<6, 6>&,
                                               const NodeGraph&, std::span<const Node>,
                                               std::span<const Index>, std::span<const Node>);

}  // namespace palpate::fem
