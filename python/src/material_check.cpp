#include "material_check.hpp"

#include <nlohmann/json.hpp>
#include <string>

#include <palpate/error.hpp>

#include "fem/material_check.hpp"
#include "scene/reader.hpp"
#include "scene/writer.hpp"

namespace palpate::python {

void check_material(const Material& material) {
  const std::string source = "Material";
  try {
    Material copy = material;
    scene_format::Writer writer("");
    describe(writer, copy);
    const nlohmann::json json = writer.take();
    scene_format::Context context{.source = source};
    scene_format::Reader reader(context, "", json);
    describe(reader, copy);
    reader.finish();
    fem::check_material(material, source);
  } catch (const Error& error) {  // errors of the writer name the scene as their source: name the material
    throw Error(source, error.where(), error.found(), error.expected());
  }
}

}  // namespace palpate::python
