#include <algorithm>

#include "fem/block_products.hpp"
#include "fem/transfer.hpp"

namespace palpate::fem {

/// Some rows of the product.
struct ProductRows {
  std::vector<std::uint32_t> lengths;
  std::vector<std::uint32_t> columns;
  std::vector<Dense<6, 6>> blocks;
};

namespace {

constexpr std::size_t chunks = 16;

/// Maps column numbers to places in a list.
class Found {
 public:
  explicit Found(std::size_t count) : place_(count, none) {}
  /// Place of an item, which is appended if it is new.
  std::uint32_t place(std::uint32_t item) {
    if (place_[item] == none) {
      place_[item] = static_cast<std::uint32_t>(items_.size());
      items_.push_back(item);
    }
    return place_[item];
  }
  void sort() {
    std::ranges::sort(items_);
    for (std::uint32_t k = 0; k < items_.size(); ++k) place_[items_[k]] = k;
  }
  [[nodiscard]] const std::vector<std::uint32_t>& items() const { return items_; }
  void clear() {
    for (const std::uint32_t item : items_) place_[item] = none;
    items_.clear();
  }

 private:
  static constexpr std::uint32_t none = 0xffffffffU;
  std::vector<std::uint32_t> place_;
  std::vector<std::uint32_t> items_;
};

/// Computes rows of P^T A P. With the column p of P of an aggregate and A symmetric, its row is (A p)^T P.
template <std::size_t N>
class RowMaker {
 public:
  RowMaker(const BlockRows<N, N>& a, const BlockRows<N, 6>& transfer, std::size_t aggregate_count)
      : a_(a), transfer_(transfer), nodes_(a.size()), aggregates_(aggregate_count) {}

  /// \param column  blocks of the transfer from this aggregate; `nodes` are theirs
  void append(std::span<const std::uint32_t> column, std::span<const std::uint32_t> nodes,
              ProductRows& rows) {
    multiply(column, nodes);
    for (const std::uint32_t j : nodes_.items()) {
      for (std::uint32_t e = transfer_.begin[j]; e < transfer_.begin[j + 1]; ++e)
        aggregates_.place(transfer_.columns[e]);
    }
    aggregates_.sort();
    const std::size_t first = rows.blocks.size();
    const std::vector<std::uint32_t>& columns = aggregates_.items();
    rows.lengths.push_back(static_cast<std::uint32_t>(columns.size()));
    rows.columns.insert(rows.columns.end(), columns.begin(), columns.end());
    rows.blocks.resize(first + columns.size(), {});
    pairs_.clear();
    for (std::uint32_t k = 0; k < nodes_.items().size(); ++k) {
      const std::uint32_t j = nodes_.items()[k];
      for (std::uint32_t e = transfer_.begin[j]; e < transfer_.begin[j + 1]; ++e)
        pairs_.push_back({k, e, aggregates_.place(transfer_.columns[e])});
    }
    constexpr auto kind = N == 3 ? simd::BlockProduct::tall_transposed : simd::BlockProduct::six_transposed;
    add_products(kind, products_, transfer_.blocks, pairs_, std::span(rows.blocks).subspan(first));
    nodes_.clear();
    aggregates_.clear();
  }

 private:
  /// A p, at the nodes nodes_.
  void multiply(std::span<const std::uint32_t> column, std::span<const std::uint32_t> nodes) {
    pairs_.clear();
    for (std::size_t k = 0; k < column.size(); ++k) {
      for (std::uint32_t e = a_.begin[nodes[k]]; e < a_.begin[nodes[k] + 1]; ++e)
        pairs_.push_back({e, column[k], nodes_.place(a_.columns[e])});
    }
    products_.assign(nodes_.items().size(), {});
    constexpr auto kind = N == 3 ? simd::BlockProduct::three_transposed : simd::BlockProduct::six_transposed;
    add_products(kind, a_.blocks, transfer_.blocks, pairs_, std::span(products_));
  }

  const BlockRows<N, N>& a_;
  const BlockRows<N, 6>& transfer_;
  Found nodes_;
  Found aggregates_;
  std::vector<simd::BlockPair> pairs_;
  std::vector<Dense<N, 6>> products_;
};

}  // namespace

template <std::size_t N>
BlockRows<6, 6> galerkin(const parallel::Threads& threads, const BlockRows<N, N>& a,
                         const BlockRows<N, 6>& transfer, std::size_t aggregate_count) {
  const ColumnLists columns = columns_of(transfer, aggregate_count);
  const std::size_t grain = aggregate_count / chunks + 1;
  std::vector<ProductRows> parts(parallel::chunk_count(aggregate_count, grain));
  parallel::for_chunks(threads, aggregate_count, grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         RowMaker<N> maker(a, transfer, aggregate_count);
                         for (std::size_t row = begin; row < end; ++row) {
                           const std::size_t first = columns.begin[row];
                           const std::size_t count = columns.begin[row + 1] - first;
                           maker.append(std::span(columns.blocks).subspan(first, count),
                                        std::span(columns.rows).subspan(first, count), parts[chunk]);
                         }
                       });
  BlockRows<6, 6> result;
  std::size_t blocks = 0;
  for (const ProductRows& part : parts) blocks += part.blocks.size();
  result.columns.reserve(blocks);
  result.blocks.reserve(blocks);
  for (const ProductRows& part : parts) {
    for (const std::uint32_t length : part.lengths) result.begin.push_back(result.begin.back() + length);
    result.columns.insert(result.columns.end(), part.columns.begin(), part.columns.end());
    result.blocks.insert(result.blocks.end(), part.blocks.begin(), part.blocks.end());
  }
  return result;
}

template BlockRows<6, 6> galerkin(const parallel::Threads&, const BlockRows<3, 3>&, const BlockRows<3, 6>&,
                                  std::size_t);
template BlockRows<6, 6> galerkin(const parallel::Threads&, const BlockRows<6, 6>&, const BlockRows<6, 6>&,
                                  std::size_t);

}  // namespace palpate::fem
