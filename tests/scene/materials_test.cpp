// The keys of laws of elasticity and fibres: read, written, and refused in one line.
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>

#include "scene/scene.hpp"

namespace palpate {
namespace {

Scene read(const std::string& material) {
  return read_scene_text(
      R"({"name": "s", "bodies": [{"ball": {"radius": 0.1, "resolution": 1}, "material": )" + material +
          "}]}",
      "s.json");
}

std::string refused(const std::string& material) {
  try {
    read(material);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

TEST(SceneMaterial, ReadsAndWritesLawsAndFibres) {
  const Scene scene =
      read(R"({"model": "mooney-rivlin", "mooney_fraction": 0.25, "fibres": {"direction": [0, 1, 2],
    "stiffness": 3, "exponent": 0.5, "active_stress": 7, "activation": {"times": [0, 1], "factors": [0, 0.75]}}})");
  const Scene again = read_scene_text(write_scene(scene), "again.json");
  for (const Scene* s : {&scene, &again}) {
    const Material& m = s->bodies[0].material.value();
    EXPECT_EQ(m.model, MaterialModel::mooney_rivlin);
    EXPECT_EQ(m.mooney_fraction, 0.25);
    EXPECT_EQ(m.fibres.direction.z, 2.0);
    EXPECT_EQ(m.fibres.stiffness, 3.0);
    EXPECT_EQ(m.fibres.exponent, 0.5);
    EXPECT_EQ(m.fibres.active_stress, 7.0);
    EXPECT_EQ(m.fibres.activation.factors, (std::vector<double>{0.0, 0.75}));
  }
  EXPECT_EQ(read("{}").bodies[0].material->model, MaterialModel::corotational);
}

TEST(SceneMaterial, RefusesWhatDoesNotGoTogether) {
  EXPECT_NE(refused(R"({"model": "stable-neo-hokean"})").find("'stable-neo-hookean'"), std::string::npos);
  EXPECT_NE(refused(R"({"fibres": {"stiffness": 1}})")
                .find("material.fibres: found them with the model corotational"),
            std::string::npos);
  EXPECT_NE(refused(R"({"model": "mooney-rivlin", "plastic_yield": 0.1, "plastic_creep": 1})")
                .find("plastic_yield"),
            std::string::npos);
  EXPECT_NE(refused(R"({"model": "mooney-rivlin", "fibres": {"direction": [0, 0, 0], "stiffness": 1}})")
                .find("fibres.direction: found a zero vector"),
            std::string::npos);
  EXPECT_NE(refused(R"({"model": "mooney-rivlin", "mooney_fraction": 1.5})").find("mooney_fraction"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate
