#pragma once

#include <cstddef>
#include <nanobind/nanobind.h>
#include <string>
#include <utility>
#include <vector>

#include "pickling.hpp"

namespace palpate::python {

namespace nb = nanobind;

/// Binds the members of a plain struct as read-only attributes, with as_dict() and repr().
template <class Struct>
class Fields {
 public:
  explicit Fields(nb::class_<Struct>& bound) : bound_(bound) {}
  ~Fields() {
    refuse_pickling(bound_, "keep what as_dict() returns");
    bound_.def("__repr__", [names = names_](nb::handle self) {
      std::string text = "palpate." + nb::cast<std::string>(self.type().attr("__name__")) + "(";
      for (std::size_t i = 0; i < names.size(); ++i)
        text += (i > 0 ? ", " : "") + std::string(names[i]) + "=" + nb::repr(self.attr(names[i])).c_str();
      return text + ")";
    });
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
