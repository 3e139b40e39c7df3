#include "scenes/people/data_set/read_people_set.h"
#include "tests/fuzz/attempt.h"
#include "tests/scenes/people/toy_people.h"

/// people.json up to the first zero byte, and samples.json of its shard after it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  static const bool written = (scenes::write_toy_people(fuzz::folder() / "set", 2, 1), true);
  const std::string bytes = fuzz::text(data, size);
  const std::size_t end = std::min(bytes.find(char{0}), bytes.size());
  write_bytes(fuzz::folder() / "set/people.json", bytes.substr(0, end));
  if (end < bytes.size()) write_bytes(fuzz::folder() / "set/shard_00000/samples.json", bytes.substr(end + 1));
  return fuzz::attempt([&] { const scenes::PeopleSet set({fuzz::folder() / "set"}, !written); });
}
