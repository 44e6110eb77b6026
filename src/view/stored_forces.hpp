#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/forces.hpp>

namespace palpate::view {

/// The forces on bodies in each step of a run, from forces.csv.
class StoredForces {
 public:
  StoredForces() = default;
  /// \param names  of the bodies, in their order.
  ///
  /// Without the file, or if it is for other bodies, there are no forces. A truncated row is left out.
  StoredForces(const std::filesystem::path& file, std::span<const std::string> names);

  [[nodiscard]] bool any() const { return !times_.empty(); }
  /// For each body, the wrenches in the step that led to a time, in the form of wrenches_json(); empty where
  /// no row has that time.
  [[nodiscard]] nlohmann::ordered_json at_time(double time) const;
  /// {"times": [...], "bodies": [[...] per body]}: lengths of the contact forces over the run; for long runs
  /// the largest of each interval.
  [[nodiscard]] nlohmann::ordered_json history() const;

 private:
  struct Columns {
    std::size_t contact = 0;          ///< the first of six columns
    std::optional<std::size_t> held;  ///< the same
  };
  bool find_columns(const std::vector<std::string>& header, std::span<const std::string> names);
  void add_row(const std::vector<std::string>& fields);

  std::size_t time_column_ = 0;
  std::vector<Columns> columns_;  ///< (n_bodies)
  std::vector<double> times_;     ///< ascending
  std::vector<double> values_;  ///< (rows x 12 n_bodies): contact wrench, then held wrench (zero if not held)
};

}  // namespace palpate::view
