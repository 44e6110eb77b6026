// The keys of laws of elasticity and fibres: read, written, and refused in one line.
#include <array>
#include <gtest/gtest.h>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/tissues.hpp>

#include "scene/scene.hpp"

namespace palpate {
namespace {

Scene read_material(const std::string& material) {
  return read_scene_text(
      R"({"name": "s", "bodies": [{"ball": {"radius": 0.1, "resolution": 1}, "material": )" + material +
          "}]}",
      "s.json");
}

std::string refused(const std::string& material) {
  try {
    read_material(material);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

TEST(SceneMaterial, ReadsAndWritesLawsAndFibres) {
  const Scene scene = read_material(
      R"({"model": "mooney-rivlin", "mooney_fraction": 0.25, "elements": "smoothed", "fibres": {"direction": [0, 1, 2],
    "stiffness": 3, "exponent": 0.5, "active_stress": 7, "activation": {"times": [0, 1], "factors": [0, 0.75]}}})");
  const Scene again = read_scene_text(write_scene(scene), "again.json");
  for (const Scene* s : {&scene, &again}) {
    const Material& m = s->bodies[0].material.value();
    EXPECT_EQ(m.model, MaterialModel::mooney_rivlin);
    EXPECT_EQ(m.mooney_fraction, 0.25);
    EXPECT_EQ(m.elements, ElementKind::smoothed);
    EXPECT_EQ(m.fibres.direction.z, 2.0);
    EXPECT_EQ(m.fibres.stiffness, 3.0);
    EXPECT_EQ(m.fibres.exponent, 0.5);
    EXPECT_EQ(m.fibres.active_stress, 7.0);
    EXPECT_EQ(m.fibres.activation.factors, (std::vector<double>{0.0, 0.75}));
  }
  EXPECT_EQ(read_material("{}").bodies[0].material->model, MaterialModel::corotational);
}

TEST(SceneMaterial, RefusesWhatDoesNotGoTogether) {
  EXPECT_NE(refused(R"({"model": "stable-neo-hokean"})").find("'stable-neo-hookean'"), std::string::npos);
  EXPECT_NE(refused(R"({"elements": "smothed"})").find("'smoothed'"), std::string::npos);
  EXPECT_NE(refused(R"({"elements": "smoothed", "poisson_ratio": -0.1})").find("smoothed elements"),
            std::string::npos);
  EXPECT_NE(refused(R"({"elements": "smoothed", "plastic_yield": 0.1, "plastic_creep": 1})")
                .find("plastic_yield: found plasticity with smoothed elements"),
            std::string::npos);
  EXPECT_NE(refused(R"({"fibres": {"stiffness": 1}})")
                .find("material.fibres: found fibres with the model corotational"),
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

TEST(SceneMaterial, ReadsAndWritesViscosity) {
  const Scene scene = read_material(R"({"viscosity": {"fractions": [0.25, 0.5], "times": [0.01, 3]}})");
  const Scene again = read_scene_text(write_scene(scene), "again.json");
  for (const Scene* s : {&scene, &again}) {
    const Viscosity& viscosity = s->bodies[0].material->viscosity;
    EXPECT_EQ(viscosity.fractions, (std::vector<double>{0.25, 0.5}));
    EXPECT_EQ(viscosity.times, (std::vector<double>{0.01, 3.0}));
  }
  EXPECT_FALSE(read_material("{}").bodies[0].material->viscosity.any());
  EXPECT_EQ(write_scene(read_material("{}")).find("viscosity"), std::string::npos);
}

TEST(SceneMaterial, RefusesASeriesThatIsNone) {
  const std::array<std::pair<std::string, std::string>, 6> cases{{
      {R"({"fractions": [0.5, 0.5], "times": [1, 2]})",
       "viscosity.fractions: found a sum of 1, expected a sum < 1"},
      {R"({"fractions": [-0.5], "times": [1]})",
       "viscosity.fractions[0]: found -0.5, expected a number in [0, 1]"},
      {R"({"fractions": [0.5], "times": [0]})", "viscosity.times[0]: found 0, expected a number > 0"},
      {R"({"fractions": [0.5], "times": [1, 2]})", "viscosity.times: found 2, expected as many as fractions"},
      {R"({"fractions": [], "times": []})", "viscosity.times: found 0"},
      {R"({"fractions": [0.5]})", "viscosity.times: found nothing"},
  }};
  for (const auto& [text, message] : cases)
    EXPECT_NE(refused(R"({"viscosity": )" + text + "}").find(message), std::string::npos)
        << refused(R"({"viscosity": )" + text + "}");
}

/// In a scene in mm, g and ms: pressures in MPa, densities in g/mm^3.
TEST(SceneMaterial, PresetsAreDefaultsOfTheirKeysInTheUnitsOfTheScene) {
  const auto of = [](const std::string& material) {
    return read_scene_text(
               R"({"units": {"length": "mm", "mass": "g", "time": "ms"}, "gravity": [0, 0, 0],
                   "bodies": [{"ball": {"radius": 10, "resolution": 1}, "material": )" +
                   material + "}]}",
               "s.json")
        .bodies[0]
        .material.value();
  };
  const Material bone = of(R"({"tissue": "cortical-bone"})");
  EXPECT_DOUBLE_EQ(bone.young_modulus, 17e3);
  EXPECT_DOUBLE_EQ(bone.density, 1.92e-3);
  EXPECT_EQ(bone.poisson_ratio, 0.3);
  EXPECT_EQ(bone.model, MaterialModel::corotational);
  EXPECT_EQ(bone.tissue, Tissue::cortical_bone);
  const Material fat = of(R"({"density": 1e-3, "tissue": "fat", "model": "mooney-rivlin"})");
  EXPECT_DOUBLE_EQ(fat.young_modulus, 3.25e-3);
  EXPECT_EQ(fat.density, 1e-3);
  EXPECT_EQ(fat.model, MaterialModel::mooney_rivlin);
}

TEST(SceneMaterial, PresetsAreWrittenAsTheirValues) {
  // The given modulus is the default of materials without a preset: it must not get lost.
  const Scene scene = read_material(R"({"tissue": "liver", "young_modulus": 100000})");
  const Material again = read_scene_text(write_scene(scene), "again.json").bodies[0].material.value();
  EXPECT_EQ(again.young_modulus, 100000.0);
  EXPECT_EQ(again.density, 1060.0);
  EXPECT_EQ(again.model, MaterialModel::stable_neo_hookean);
  EXPECT_FALSE(again.tissue.has_value());
  EXPECT_NE(refused(R"({"tissue": "livre"})").find("'liver'"), std::string::npos);
}

TEST(SceneMaterial, EveryPresetIsTakenAndHasASource) {
  for (std::size_t i = 0; i < tissue_names.size(); ++i) {
    const auto tissue = static_cast<Tissue>(i);
    EXPECT_NO_THROW(read_material(R"({"tissue": ")" + std::string(tissue_names[i]) + R"("})"));
    EXPECT_GT(tissue_info(tissue).density, 900.0);
    EXPECT_NE(tissue_info(tissue).source.find('('), std::string_view::npos);
    EXPECT_FALSE(tissue_info(tissue).measured.empty());
  }
}

}  // namespace
}  // namespace palpate
