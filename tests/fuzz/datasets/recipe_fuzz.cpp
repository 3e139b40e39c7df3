#include "datasets/recipe/recipe.h"
#include "tests/fuzz/attempt.h"

/// Recipes of data sets.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  return fuzz::attempt([&] { datasets::read_recipe(parse_json(fuzz::text(data, size), "fuzz"), "fuzz"); });
}
