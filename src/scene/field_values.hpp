#pragma once

#include <span>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/field_list.hpp"

namespace palpate {

/// The numbers of a field, row by row of its components.
struct FieldArray {
  const FieldInfo* info = nullptr;
  std::vector<double> values;
};
struct FieldArrays {
  std::vector<FieldArray> of_points;  ///< (n_points x components) each
  std::vector<FieldArray> of_tets;    ///< (n_tets x components), for fields with values at tets
};

/// Fields of the current state of a simulation, in the order of their names. Each source (stress of tets, of
/// points, tractions) is computed at most once. Throws Error on an unknown name, and for reactions that the
/// last step did not record; at the start, before the first step, they are zero.
[[nodiscard]] FieldArrays field_arrays(const Simulation& simulation, std::span<const std::string> names);

/// One field, at points or at tets. Throws Error as field_arrays() does, and for contacts or reactions at
/// tets.
[[nodiscard]] FieldArray field_array(const Simulation& simulation, const std::string& name, bool of_tets);

/// For each row: its number, or the length of its vector.
[[nodiscard]] std::vector<double> row_sizes(std::vector<double> values, int components);

/// One number for each point: the value of the field, or the length of its vector. NaN where it has no value.
[[nodiscard]] std::vector<double> point_scalars(const Simulation& simulation, const std::string& name);

}  // namespace palpate
