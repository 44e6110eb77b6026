#include <algorithm>

#include "fem/transfer.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t chunks = 16;

/// Maps column numbers to indices in the row that is being made.
class Found {
 public:
  explicit Found(std::size_t count) : place_(count, none) {}
  /// Place of an item; sets `added` if it is new.
  std::size_t place(std::uint32_t item, bool& added) {
    added = place_[item] == none;
    if (added) {
      place_[item] = static_cast<std::uint32_t>(items_.size());
      items_.push_back(item);
    }
    return place_[item];
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

}  // namespace

template <std::size_t N>
BlockRows<6, 6> galerkin(const parallel::Threads& threads, const BlockRows<N, N>& a,
                         const BlockRows<N, 6>& transfer, std::size_t aggregate_count) {
  const BlockRows<6, N> restriction = transposed(transfer, aggregate_count);
  struct Entry {
    std::uint32_t column;
    Dense<6, 6> block;
  };
  std::vector<std::vector<Entry>> rows(aggregate_count);
  const std::size_t grain = aggregate_count / chunks + 1;
  parallel::for_chunks(threads, aggregate_count, grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    Found nodes(a.size());
    Found aggregates(aggregate_count);
    std::vector<Dense<6, N>> products;
    for (std::size_t row = begin; row < end; ++row) {
      products.clear();
      bool added = false;
      for (std::uint32_t k = restriction.begin[row]; k < restriction.begin[row + 1]; ++k) {
        const std::uint32_t i = restriction.columns[k];
        for (std::uint32_t e = a.begin[i]; e < a.begin[i + 1]; ++e) {
          const std::size_t place = nodes.place(a.columns[e], added);
          if (added) products.push_back({});
          add_product<6, N, N>(products[place], restriction.blocks[k], a.blocks[e]);
        }
      }
      std::vector<Entry>& entries = rows[row];
      for (std::size_t k = 0; k < products.size(); ++k) {
        const std::uint32_t j = nodes.items()[k];
        for (std::uint32_t e = transfer.begin[j]; e < transfer.begin[j + 1]; ++e) {
          const std::size_t place = aggregates.place(transfer.columns[e], added);
          if (added) entries.push_back({transfer.columns[e], {}});
          add_product<6, N, 6>(entries[place].block, products[k], transfer.blocks[e]);
        }
      }
      std::ranges::sort(entries, {}, &Entry::column);
      nodes.clear();
      aggregates.clear();
    }
  });
  BlockRows<6, 6> result;
  for (const std::vector<Entry>& entries : rows) {
    for (const Entry& entry : entries) {
      result.columns.push_back(entry.column);
      result.blocks.push_back(entry.block);
    }
    result.begin.push_back(static_cast<std::uint32_t>(result.columns.size()));
  }
  return result;
}

template BlockRows<6, 6> galerkin(const parallel::Threads&, const BlockRows<3, 3>&, const BlockRows<3, 6>&,
                                  std::size_t);
template BlockRows<6, 6> galerkin(const parallel::Threads&, const BlockRows<6, 6>&, const BlockRows<6, 6>&,
                                  std::size_t);

}  // namespace palpate::fem
