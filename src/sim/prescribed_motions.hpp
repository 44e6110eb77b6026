#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/model.hpp>

#include "parallel/parallel.hpp"

namespace palpate {

/// The points that follow motions, and their positions over time.
class PrescribedMotions {
 public:
  /// \param motion_of_point  (n_points) or empty
  /// \param start  (n_points) positions before the motion is applied; copied
  ///
  /// Throws Error naming motion and keyframe: no keyframe, times that do not grow, numbers that are not
  /// finite, a zero quaternion, an index out of range.
  PrescribedMotions(std::vector<Motion> motions, std::span<const Index> motion_of_point,
                    std::span<const Vec3> start);

  [[nodiscard]] std::span<const Index> points() const { return points_; }            ///< ascending
  [[nodiscard]] std::span<const Index> motion_of_points() const { return motion_; }  ///< of points()
  [[nodiscard]] Index motion_count() const { return static_cast<Index>(motions_.size()); }
  /// Positions of points() at a time, in the order of points(); valid until the next call.
  std::span<const Vec3> positions(const parallel::Threads& threads, double time);
  /// All points at the start (n_points x 3). Prescribed points are where their motion is at time 0.
  [[nodiscard]] std::vector<Vec3> start_positions(const parallel::Threads& threads,
                                                  std::span<const Vec3> points_rest);
  /// Replaces a motion. Throws Error, and changes nothing, on a number out of range and as the constructor
  /// does.
  void replace(Index number, Motion motion);
  [[nodiscard]] std::span<const Motion> motions() const { return motions_; }
  /// Replaces all motions. Throws Error, and changes nothing, if their number differs, and as the constructor
  /// does.
  void set_motions(std::vector<Motion> motions);
  /// Time of the last keyframe of all motions that have points, s; 0 if there are none. Nothing moves after
  /// it.
  [[nodiscard]] double end() const;

 private:
  std::vector<Motion> motions_;
  std::vector<Index> points_;
  std::vector<Index> motion_;  ///< of points_
  std::vector<Vec3> start_;    ///< of points_
  std::vector<Vec3> positions_;
  std::vector<std::uint8_t> moves_points_;  ///< of motions_
};

}  // namespace palpate
