#include "sort/comparison.hpp"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

/// Words of a chunk and of a piece of a merge.
constexpr std::size_t grain = std::size_t{1} << 14;

using Words = std::span<const std::uint64_t>;

/// The number of words from a among the first `rank` words of the merge of a and b.
std::size_t taken_from(Words a, Words b, std::size_t rank) {
  std::size_t low = rank > b.size() ? rank - b.size() : 0;
  std::size_t high = std::min(rank, a.size());
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (a[middle] <= b[rank - middle - 1]) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/// Merges without branches on the order of words, which is unpredictable.
void merge(Words a, Words b, std::uint64_t* out) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    const std::uint64_t x = a[i];
    const std::uint64_t y = b[j];
    const bool from_a = x <= y;
    *out++ = from_a ? x : y;
    i += from_a ? 1 : 0;
    j += from_a ? 0 : 1;
  }
  out = std::copy(a.begin() + static_cast<std::ptrdiff_t>(i), a.end(), out);
  std::copy(b.begin() + static_cast<std::ptrdiff_t>(j), b.end(), out);
}

/// The part [begin, end) of the merge of a and b.
void merge_piece(Words a, Words b, std::size_t begin, std::size_t end, std::uint64_t* out) {
  const std::size_t a_begin = taken_from(a, b, begin);
  const std::size_t a_end = taken_from(a, b, end);
  const Words a_part = a.subspan(a_begin, a_end - a_begin);
  const Words b_part = b.subspan(begin - a_begin, (end - a_end) - (begin - a_begin));
  merge(a_part, b_part, out);
}

}  // namespace

void ComparisonSort::sort_chunk(std::span<std::uint64_t> words, std::span<std::uint64_t> scratch) const {
  // Moves ascending words to the front and the others to scratch. A word before a smaller one may itself be
  // out of order (its key grew). If its predecessor fits before the smaller one, it goes to scratch too.
  std::size_t kept = 0;
  std::size_t out = 0;
  const std::size_t most_out = words.size() / 4;
  std::size_t i = 0;
  for (; i < words.size() && out + 2 <= most_out; ++i) {
    const std::uint64_t word = words[i];
    if (kept == 0 || words[kept - 1] <= word) {
      words[kept++] = word;
    } else if (kept == 1 || words[kept - 2] <= word) {
      scratch[out++] = words[kept - 1];
      words[kept - 1] = word;
    } else {
      scratch[out++] = word;
    }
  }
  if (i < words.size()) {
    std::copy_n(scratch.begin(), out, words.begin() + static_cast<std::ptrdiff_t>(kept));
    std::sort(words.begin(), words.end());
    return;
  }
  if (out == 0) return;
  std::sort(scratch.begin(), scratch.begin() + static_cast<std::ptrdiff_t>(out));
  // From the back, so that the merge is in place.
  std::size_t place = words.size();
  while (out > 0) {
    const bool from_kept = kept > 0 && words[kept - 1] > scratch[out - 1];
    words[--place] = from_kept ? words[--kept] : scratch[--out];
  }
}

void ComparisonSort::merge_runs(const parallel::Threads& threads, Words in, std::size_t run,
                                std::span<std::uint64_t> out) const {
  // Runs are multiples of the grain, so no piece crosses a pair.
  parallel::for_chunks(threads, in.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    const std::size_t pair = begin - begin % (2 * run);
    const std::size_t middle = std::min(in.size(), pair + run);
    const std::size_t last = std::min(in.size(), pair + 2 * run);
    merge_piece(in.subspan(pair, middle - pair), in.subspan(middle, last - middle), begin - pair, end - pair,
                out.data() + begin);
  });
}

void ComparisonSort::operator()(const parallel::Threads& threads, std::vector<std::uint64_t>& words) {
  scratch_.reserve(words.capacity());  // the two buffers are swapped
  scratch_.resize(words.size());
  parallel::for_chunks(threads, words.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    sort_chunk(std::span(words).subspan(begin, end - begin), std::span(scratch_).subspan(begin, end - begin));
  });
  for (std::size_t run = grain; run < words.size(); run *= 2) {
    bool ordered = true;
    for (std::size_t i = run; i < words.size() && ordered; i += run) ordered = words[i - 1] <= words[i];
    if (ordered) return;
    merge_runs(threads, words, run, scratch_);
    std::swap(words, scratch_);
  }
}

}  // namespace palpate
