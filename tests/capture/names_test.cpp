#include "capture/names.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

enum class Falloff { none, cos4, forgotten };
constexpr Named<Falloff> kFalloffs[] = {{"none", Falloff::none, "the same light everywhere"},
                                        {"cos4", Falloff::cos4, "fourth power of the cosine"}};

TEST(Names, NameAndValueFindEachOther) {
  for (const auto& row : kFalloffs) {
    EXPECT_STREQ(name_of(kFalloffs, row.value), row.name);
    EXPECT_EQ(value_named(kFalloffs, row.name, "--falloff"), row.value);
  }
  EXPECT_EQ(find_named(kFalloffs, "cos"), nullptr);
  EXPECT_EQ(names_of(kFalloffs), (std::vector<std::string>{"none", "cos4"}));
}

TEST(Names, AnUnknownNameIsRefusedWithWhatIsAllowed) {
  EXPECT_EQ(message_of<InputError>([] { value_named(kFalloffs, "cos5", "--falloff"); }),
            "--falloff: cos5: must be one of 'none', 'cos4'; did you mean 'cos4'?");
}

TEST(Names, AValueWithoutARowIsNoOutOfBoundsRead) {
  EXPECT_THROW(name_of(kFalloffs, Falloff::forgotten), std::logic_error);
}

TEST(Names, AreReadFromJson) {
  const nlohmann::json json = {{"falloff", "cos4"}, {"wrong", "cos"}};
  Fields fields(json, "lens.json", "/lens");
  Falloff falloff = Falloff::none;
  read_named(fields, "absent", falloff, kFalloffs);
  EXPECT_EQ(falloff, Falloff::none);
  read_named(fields, "falloff", falloff, kFalloffs);
  EXPECT_EQ(falloff, Falloff::cos4);
  EXPECT_EQ(message_of<InputError>([&] { read_named(fields, "wrong", falloff, kFalloffs); }),
            "lens.json: /lens/wrong: \"cos\": must be one of 'none', 'cos4'; did you mean 'cos4'?");
}

}  // namespace
}  // namespace dualpixel
