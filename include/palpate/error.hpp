#pragma once

#include <stdexcept>
#include <string>

namespace palpate {

/// The one exception of the library: a bad file, mesh, scene or parameter.
///
/// what() is a single line "SOURCE: WHERE: found FOUND, expected EXPECTED" (WHERE is left out when empty).
class Error : public std::runtime_error {
 public:
  /// \param source    the file, or the function or parameter set that was given the bad value
  /// \param where     line, index or key inside the source ("line 12", "tet 7", "bodies[2].density");
  ///                  may be empty
  /// \param found     what was found there
  /// \param expected  what was expected
  Error(std::string source, std::string where, std::string found, std::string expected);

  [[nodiscard]] const std::string& source() const { return source_; }  ///< as constructed
  [[nodiscard]] const std::string& where() const { return where_; }    ///< as constructed
  [[nodiscard]] const std::string& found() const { return found_; }    ///< as constructed
  /// As constructed.
  [[nodiscard]] const std::string& expected() const { return expected_; }

 private:
  std::string source_;
  std::string where_;
  std::string found_;
  std::string expected_;
};

}  // namespace palpate
