// lens_models/lens.schema.json says of a lens file what the reader says.
// GCC 12 misjudges std::string and std::regex in valijson (bugs 105651, 105562).
#pragma GCC diagnostic ignored "-Wrestrict"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "capture/json_fields.h"
#include "simulator/lens/lens.h"
#include "simulator/lens/models.h"

namespace dualpixel::simulator::testing {
namespace {

bool valid(const nlohmann::json& lens) {
  static const nlohmann::json document = read_json_file(DUALPIXEL_SOURCE_DIR "/lens_models/lens.schema.json");
  valijson::Schema schema;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(document), schema);
  valijson::Validator validator;
  const valijson::adapters::NlohmannJsonAdapter target(lens);
  return validator.validate(schema, target, nullptr);
}

TEST(LensSchema, AcceptsEveryShippedLens) {
  int count = 0;
  for (const char* folder : {DUALPIXEL_SOURCE_DIR "/lens_models", DUALPIXEL_SOURCE_DIR "/tests/data/optics"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const nlohmann::json json = entry.path().extension() == ".json" ? read_json_file(entry.path()) : nlohmann::json();
      if (!json.is_object() || !json.contains("version")) continue;
      EXPECT_TRUE(valid(json)) << entry.path();
      ++count;
    }
  }
  EXPECT_GE(count, 17);
}

TEST(LensSchema, ListsTheReadersNames) {
  const nlohmann::json schema = read_json_file(DUALPIXEL_SOURCE_DIR "/lens_models/lens.schema.json")["properties"];
  EXPECT_EQ(schema["model"]["enum"], nlohmann::json(names_of(kLensModels)));
  EXPECT_EQ(schema["split"]["properties"]["model"]["enum"], nlohmann::json(names_of(kSplitKinds)));
  EXPECT_EQ(schema["focusing"]["enum"], nlohmann::json(names_of(kFocusings)));
  EXPECT_EQ(schema["falloff"]["enum"], nlohmann::json(names_of(kFalloffs)));
}

TEST(LensSchema, RefusesWhatTheReaderRefuses) {
  nlohmann::json lens = read_json_file(DUALPIXEL_SOURCE_DIR "/lens_models/phone_6p_4.2mm_f1.8.json");
  for (const auto& [pointer, value] :
       std::initializer_list<std::pair<const char*, nlohmann::json>>{{"/focal_lenght_mm", 4},
                                                                     {"/surfaces/1/radius", 4},
                                                                     {"/surfaces/1/asphere/31", 4},
                                                                     {"/surfaces/1/semi_diameter_mm", 0},
                                                                     {"/split", {{"model", "soft"}}},
                                                                     {"/band_samples", 2},
                                                                     {"/version", 2}}) {
    nlohmann::json bad = lens;
    bad[nlohmann::json::json_pointer(pointer)] = value;
    EXPECT_FALSE(valid(bad)) << pointer;
  }
  lens.erase("surfaces");
  EXPECT_FALSE(valid(lens));
}

}  // namespace
}  // namespace dualpixel::simulator::testing
