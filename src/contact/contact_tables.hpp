#pragma once

#include <array>
#include <cstddef>

#include "contact/contact_table.hpp"

namespace palpate {

/// The tables of the detections that matter: of the last one, of the one before it while the next is made,
/// and of one that is held while others follow. They change places, so that each keeps its memory.
class ContactTables {
 public:
  [[nodiscard]] ContactTable& now() { return tables_[now_]; }
  [[nodiscard]] const ContactTable& now() const { return tables_[now_]; }
  /// Of the detection before now(), during a detection.
  [[nodiscard]] const ContactTable& last() const { return tables_[last_]; }

  /// A table for the next detection becomes now(); now() becomes last().
  void begin() {
    last_ = now_;
    now_ = 0;
    while (now_ == last_ || now_ == held_) ++now_;
  }
  /// Keeps now() while others follow.
  void hold() { held_ = now_; }
  /// Back to the table that was held.
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
