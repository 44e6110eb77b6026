#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "scene/key_lister.hpp"

namespace palpate {
namespace {

using Keys = scene_format::KeyLister::Keys;
using nlohmann::ordered_json;

const ordered_json& resolved(const ordered_json& schema, const ordered_json& part) {
  if (!part.contains("$ref")) return part;
  return schema.at(ordered_json::json_pointer(part.at("$ref").get<std::string>().substr(1)));
}

/// Every property of the schema with its default, by the same paths as the lister's; objects must be closed.
void collect(const ordered_json& schema, const ordered_json& part, const std::string& path, Keys& keys) {
  if (part.contains("items")) collect(schema, resolved(schema, part.at("items")), path + "[]", keys);
  if (!part.contains("properties")) return;
  EXPECT_EQ(part.value("additionalProperties", true), false) << path;
  for (const auto& [key, property] : part.at("properties").items()) {
    const std::string key_path = path.empty() ? key : path + "." + key;
    keys[key_path] = property.contains("default") ? property.at("default") : ordered_json(nullptr);
    EXPECT_TRUE(property.contains("description")) << key_path;
    collect(schema, resolved(schema, property), key_path, keys);
  }
}

TEST(SceneSchema, HasTheKeysAndDefaultsThatTheReaderHas) {
  std::ifstream file(PALPATE_SOURCE_DIR "/docs/scene.schema.json");
  const auto schema = ordered_json::parse(file);
  Keys published;
  collect(schema, schema, "", published);
  Keys known = scene_format::list_scene_keys();
  for (auto& [path, value] : known) {
    if (value == "") value = nullptr;  // a name that is absent is no default
  }
  for (const auto& [path, value] : known) {
    ASSERT_TRUE(published.contains(path)) << path << " is read but not published";
    EXPECT_EQ(published.at(path), value) << path;
  }
  for (const auto& [path, value] : published)
    EXPECT_TRUE(known.contains(path)) << path << " is published but not read";
  EXPECT_GT(known.size(), 50U);
}

TEST(SceneSchema, HasTheNamesOfTheEnumerations) {
  std::ifstream file(PALPATE_SOURCE_DIR "/docs/scene.schema.json");
  const auto contact = ordered_json::parse(file).at("properties").at("contact").at("properties");
  EXPECT_EQ(contact.at("structure").at("enum"), ordered_json(structure_names));
  EXPECT_EQ(contact.at("order").at("enum"), ordered_json(order_names));
  EXPECT_EQ(contact.at("sort").at("enum"), ordered_json(sort_names));
}

}  // namespace
}  // namespace palpate
