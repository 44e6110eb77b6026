#include "line_balls.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "geometry/box_tree.hpp"
#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

/// Length of the edges on lines relative to the size of triangles there. Longer edges cut the curves of lines
/// short, and their balls keep more of the interfaces free of points.
constexpr double of_size = 0.5;
/// Radius of a ball relative to the distance of its neighbours; above 0.5, so that their balls overlap.
constexpr double of_distance = 0.6;
constexpr double of_nearest = 0.9;  ///< largest radius relative to the distance of the nearest neighbour
/// Least distance of neighbours relative to the wanted length. Junctions of lines may be nearer.
constexpr double least_length = 0.5;
constexpr std::ptrdiff_t least_run = 3;  ///< parts of lines with fewer points are left out

/// A line between two junctions, or a closed one: then the first point of the graph is the last, too.
using Chain = std::vector<std::size_t>;

bool is_junction(const TissueLines& lines, std::size_t point) {
  return lines.next[point].size() != 2;
}

std::vector<Chain> chains_of(const TissueLines& lines) {
  std::vector<Chain> chains;
  std::set<std::pair<std::size_t, std::size_t>> used;
  const auto walk = [&](std::size_t from, std::size_t to) {
    if (!used.insert(std::minmax(from, to)).second) return;
    Chain chain{from, to};
    while (to != chain.front() && !is_junction(lines, to)) {
      const std::size_t onward = lines.next[to][0] == from ? lines.next[to][1] : lines.next[to][0];
      used.insert(std::minmax(to, onward));
      from = std::exchange(to, onward);
      chain.push_back(to);
    }
    chains.push_back(std::move(chain));
  };
  for (const bool junctions : {true, false}) {  // closed lines without a junction are what is left
    for (std::size_t p = 0; p < lines.points.size(); ++p) {
      if (is_junction(lines, p) != junctions) continue;
      for (const std::size_t q : lines.next[p]) walk(p, q);
    }
  }
  return chains;
}

/// Points on a line, ends included, whose distances along it are about `of_size` times the size; none on a
/// closed line that is shorter than three times that.
std::vector<Vec3> divided(const std::vector<Vec3>& line, const SizeField& size, bool closed) {
  constexpr std::size_t least_of_closed = 3;
  std::vector<double> sum{0.0};  // of lengths relative to the wanted ones
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double wanted = of_size * size(0.5 * (line[i] + line[i - 1]));
    sum.push_back(sum.back() + length(line[i] - line[i - 1]) / wanted);
  }
  const auto parts = std::max(std::size_t{1}, static_cast<std::size_t>(std::lround(sum.back())));
  if (closed && parts < least_of_closed) return {};
  std::vector<Vec3> points{line.front()};
  std::size_t i = 1;
  for (std::size_t n = 1; n < parts; ++n) {
    const double wanted = sum.back() * static_cast<double>(n) / static_cast<double>(parts);
    while (i + 1 < line.size() && sum[i] < wanted) ++i;
    const double part = (wanted - sum[i - 1]) / (sum[i] - sum[i - 1]);
    points.push_back(line[i - 1] + part * (line[i] - line[i - 1]));
  }
  points.push_back(line.back());
  return points;
}

/// The points of all divided lines, and which of them a mesh can follow.
class Placer {
 public:
  Placer(const TissueLines& lines, const SizeField& size) {
    for (const Chain& chain : chains_of(lines)) add(lines, chain, size);
    add_balls(size);
    std::vector<Box> boxes(balls_.size());
    for (std::size_t b = 0; b < balls_.size(); ++b) boxes[b] = box_of(balls_[b]);
    const BoxTree tree(std::move(boxes));
    std::ranges::stable_sort(runs_, std::greater<>{}, &Run::size);
    for (const Run& run : runs_) choose(run, tree);
  }

  [[nodiscard]] std::vector<LineBall> chosen() const {
    std::vector<LineBall> chosen;
    for (std::size_t p = 0; p < balls_.size(); ++p) {
      if (state_[p] == State::chosen) chosen.push_back(balls_[p]);
    }
    return chosen;
  }

 private:
  using Run = std::vector<std::size_t>;  ///< consecutive points of a line
  enum class State : char { open, tried, chosen, refused };

  void add(const TissueLines& lines, const Chain& chain, const SizeField& size) {
    const bool closed = chain.front() == chain.back();
    std::vector<Vec3> line;
    line.reserve(chain.size());
    for (const std::size_t p : chain) line.push_back(lines.points[p]);
    const std::vector<Vec3> places = divided(line, size, closed);
    if (places.empty()) return;
    Run run;
    for (std::size_t i = 0; i + 1 < places.size(); ++i)
      run.push_back(i == 0 ? end_at(chain.front(), places[i]) : added(places[i]));
    run.push_back(closed ? run.front() : end_at(chain.back(), places.back()));
    for (std::size_t i = 1; i < run.size(); ++i) {
      next_[run[i]].push_back(run[i - 1]);
      next_[run[i - 1]].push_back(run[i]);
    }
    runs_.push_back(std::move(run));
  }
  std::size_t end_at(std::size_t point, const Vec3& place) {
    const auto [it, is_new] = ends_.try_emplace(point, balls_.size());
    return is_new ? added(place) : it->second;
  }
  std::size_t added(const Vec3& place) {
    balls_.push_back({place, 0.0});
    next_.emplace_back();
    return balls_.size() - 1;
  }

  void add_balls(const SizeField& size) {
    state_.assign(balls_.size(), State::open);
    for (std::size_t p = 0; p < balls_.size(); ++p) {
      least_.push_back(least_length * of_size * size(balls_[p].center));
      double nearest = std::numeric_limits<double>::infinity();
      double farthest = 0.0;
      for (const std::size_t q : next_[p]) {
        const double distance = length(balls_[p].center - balls_[q].center);
        farthest = std::max(farthest, distance);
        if (distance >= least_[p]) nearest = std::min(nearest, distance);
      }
      balls_[p].radius = std::min(of_distance * farthest, of_nearest * nearest);
    }
  }
  static Box box_of(const LineBall& ball) {
    const Vec3 r{ball.radius, ball.radius, ball.radius};
    return {ball.center - r, ball.center + r};
  }

  /// Chooses the parts of a run that keep away from what was chosen before.
  void choose(Run run, const BoxTree& tree) {
    for (const std::size_t p : run) {
      if (state_[p] == State::open) state_[p] = is_free(p, tree) ? State::tried : State::refused;
    }
    const auto is_refused = [&](std::size_t p) { return state_[p] == State::refused; };
    if (run.front() == run.back()) {  // a closed line has parts between refused points, wherever it begins
      run.pop_back();
      const auto refused = std::ranges::find_if(run, is_refused);
      if (refused != run.end()) std::ranges::rotate(run, refused);
    }
    for (auto begin = run.begin(); begin != run.end();) {
      const auto end = std::find_if(begin, run.end(), is_refused);
      const bool is_long = end - begin >= least_run;
      for (const std::size_t p : std::ranges::subrange(begin, end)) {
        if (state_[p] == State::tried) state_[p] = is_long ? State::chosen : State::refused;
      }
      begin = std::find_if_not(end, run.end(), is_refused);
    }
  }
  [[nodiscard]] bool is_free(std::size_t p, const BoxTree& tree) const {
    bool free = true;
    tree.for_each_within(
        box_of(balls_[p]), [] { return 0.0; },
        [&](std::size_t q) {
          if (q == p || state_[q] == State::open || state_[q] == State::refused) return;
          const bool joined = std::ranges::find(next_[p], q) != next_[p].end();
          const double least = joined ? least_[p] : balls_[p].radius + balls_[q].radius;
          free = free && length(balls_[p].center - balls_[q].center) >= least;
        });
    return free;
  }

  std::vector<LineBall> balls_;
  std::vector<std::vector<std::size_t>> next_;  ///< (n_balls) neighbours on lines
  std::vector<double> least_;                   ///< (n_balls) least distance of neighbours
  std::vector<State> state_;                    ///< (n_balls)
  std::vector<Run> runs_;
  std::map<std::size_t, std::size_t> ends_;  ///< the ball at the end of a chain, by its point of the graph
};

}  // namespace

std::vector<LineBall> line_balls(const TissueLines& lines, const SizeField& size) {
  return Placer(lines, size).chosen();
}

}  // namespace palpate::app
