#pragma once

#include <array>
#include <cstddef>

#include "contact/contact_table.hpp"

namespace palpate {

/// The tables of three detections: the last one, the one before it (while the last one is made), and a held
/// one. They are swapped, so that each keeps its memory.
class ContactTables {
 public:
  [[nodiscard]] ContactTable& now() { return tables_[now_]; }
  [[nodiscard]] const ContactTable& now() const { return tables_[now_]; }
  /// During a detection: the table of the detection before it.
  [[nodiscard]] const ContactTable& last() const { return tables_[last_]; }

  /// Begins a detection: now() becomes last(), and another table becomes now().
  void begin() {
    last_ = now_;
    now_ = 0;
    while (now_ == last_ || now_ == held_) ++now_;
  }
  /// Holds a copy of now() during further detections.
  void hold() { held_ = now_; }
  /// Restores the held table.
  void swap_back() {
    now_ = held_;
    release();
  }
  void release() { held_ = none; }

 private:
  static constexpr std::size_t none = 3;
  std::array<ContactTable, 3> tables_;
  std::size_t now_ = 0;
  std::size_t last_ = 1;
  std::size_t held_ = none;
};

}  // namespace palpate
