#pragma once

#include <nanobind/nanobind.h>
#include <utility>
#include <vector>

namespace palpate::python {

namespace nb = nanobind;

/// Binds the members of a plain struct as read-only attributes, and as_dict(), which has them all.
template <class Struct>
class Fields {
 public:
  explicit Fields(nb::class_<Struct>& bound) : bound_(bound) {}
  ~Fields() {
    bound_.def(
        "as_dict",
        [names = std::move(names_)](nb::handle self) {
          nb::dict values;
          for (const char* name : names) values[name] = self.attr(name);
          return values;
        },
        nb::sig("def as_dict(self) -> dict[str, typing.Any]"), "All values by name.");
  }
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  template <class Member>
  Fields& add(const char* name, Member member, const char* doc) {
    bound_.def_ro(name, member, doc);
    names_.push_back(name);
    return *this;
  }
  template <class Getter>
  Fields& get(const char* name, Getter getter, const char* doc) {
    bound_.def_prop_ro(name, getter, doc);
    names_.push_back(name);
    return *this;
  }

 private:
  nb::class_<Struct>& bound_;
  std::vector<const char*> names_;
};

}  // namespace palpate::python
