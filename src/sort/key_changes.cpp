#include "sort/key_changes.hpp"

#include <algorithm>

#include "simd/key_changes.hpp"
#include "simd/merge_events.hpp"
#include "sort/word.hpp"

namespace palpate {
namespace {

constexpr std::size_t change_grain = std::size_t{1} << 13;

}  // namespace

template <class Body>
void KeyChanges::for_movers(std::size_t chunk, Body&& body) const {
  const std::uint32_t* const changed = references_changed_.data() + chunk * change_grain;
  for (std::uint32_t i = 0; i < chunks_[chunk].movers; ++i) body(changed[i]);
}

void KeyChanges::find_in_chunk(std::size_t begin, std::size_t end, Chunk& chunk) {
  std::uint32_t* const changed = references_changed_.data() + begin;
  const std::size_t size = end - begin;
  chunk = {};
  chunk.movers = static_cast<std::uint32_t>(simd::list_changes(std::span(before_).subspan(begin, size),
                                                               now_.subspan(begin, size),
                                                               static_cast<std::uint32_t>(begin), changed));
  for (std::uint32_t i = 0; i < chunk.movers; ++i) {
    chunk.appeared += before_[changed[i]] == no_key ? 1U : 0U;
    chunk.disappeared += now_[changed[i]] == no_key ? 1U : 0U;
  }
}

void KeyChanges::find(const parallel::Threads& threads, std::span<const std::uint32_t> keys) {
  references_ = keys.size();
  if (before_.size() < references_) before_.resize(references_, no_key);
  now_ = keys;
  if (before_.size() > references_) {
    padded_.assign(before_.size(), no_key);
    std::copy(keys.begin(), keys.end(), padded_.begin());
    now_ = padded_;
  }
  references_changed_.resize(before_.size());
  chunks_.resize(parallel::chunk_count(before_.size(), change_grain));
  parallel::for_chunks(threads, before_.size(), change_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         find_in_chunk(begin, end, chunks_[chunk]);
                       });
  movers_ = appeared_ = disappeared_ = 0;
  std::size_t events = 0;
  for (Chunk& chunk : chunks_) {
    chunk.first_event = events;
    events += 2 * std::size_t{chunk.movers} - chunk.appeared - chunk.disappeared;
    movers_ += chunk.movers;
    appeared_ += chunk.appeared;
    disappeared_ += chunk.disappeared;
  }
}

void KeyChanges::append_appeared(std::vector<std::uint64_t>& words) const {
  if (appeared_ == 0) return;
  for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) {
    for_movers(chunk, [&](std::uint32_t reference) {
      if (before_[reference] == no_key) words.push_back(make_word(now_[reference], reference));
    });
  }
}

void KeyChanges::list_events(const parallel::Threads& threads, std::vector<std::uint64_t>& events) {
  events.resize(2 * movers_ - appeared_ - disappeared_);
  parallel::for_each(threads, chunks_.size(), 1, [&](std::size_t chunk) {
    std::uint64_t* event = events.data() + chunks_[chunk].first_event;
    for_movers(chunk, [&](std::uint32_t reference) {
      const std::uint32_t before = before_[reference];
      const std::uint32_t now = now_[reference];
      if (before != no_key) *event++ = make_word(before, reference) | simd::removal;
      if (now != no_key) *event++ = make_word(now, reference);
    });
  });
}

void KeyChanges::accept(const parallel::Threads& threads) {
  words_ = words_now();
  parallel::for_each(threads, chunks_.size(), 1, [&](std::size_t chunk) {
    for_movers(chunk, [&](std::uint32_t reference) { before_[reference] = now_[reference]; });
  });
  before_.resize(references_);
  movers_ = appeared_ = disappeared_ = 0;
  chunks_.clear();
}

void KeyChanges::clear() {
  before_.clear();
  chunks_.clear();
  words_ = movers_ = appeared_ = disappeared_ = 0;
}

}  // namespace palpate
