#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/forces.hpp>

namespace palpate::view {

/// What acted on the bodies in each step of a run: its forces.csv.
class StoredForces {
 public:
  StoredForces() = default;
  /// \param names  of the bodies, in their order
  /// Without the file, or where it is not that of these bodies, there are no forces; a row that is cut off is
  /// left out.
  StoredForces(const std::filesystem::path& file, std::span<const std::string> names);

  [[nodiscard]] bool any() const { return !times_.empty(); }
  /// Of each body in the step that led to a time, as wrenches_json() has them; empty where no row is of it.
  [[nodiscard]] nlohmann::ordered_json at_time(double time) const;
  /// {"times": [...], "bodies": [[...] per body]}: sizes of the contact forces over the run, the largest of
  /// each stretch where steps are many.
  [[nodiscard]] nlohmann::ordered_json history() const;

 private:
  struct Columns {
    std::size_t contact = 0;          ///< the first of six
    std::optional<std::size_t> held;  ///< the same
  };
  bool find_columns(const std::vector<std::string>& header, std::span<const std::string> names);
  void add_row(const std::vector<std::string>& fields);

  std::size_t time_column_ = 0;
  std::vector<Columns> columns_;  ///< (n_bodies)
  std::vector<double> times_;     ///< growing
  std::vector<double> values_;    ///< (rows x 12 n_bodies): contact, then held (zero where it is not)
};

}  // namespace palpate::view
