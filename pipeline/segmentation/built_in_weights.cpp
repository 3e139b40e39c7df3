#include "capture/error.h"
#include "pipeline/segmentation/weights.h"

#ifdef DUALPIXEL_PERSON_WEIGHTS

// The file, unchanged, in the library's read-only data.
asm(R"(
  .pushsection .rodata
  .balign 16
  .globl dualpixel_person_weights_begin, dualpixel_person_weights_end
  .hidden dualpixel_person_weights_begin, dualpixel_person_weights_end
dualpixel_person_weights_begin:
  .incbin ")" DUALPIXEL_PERSON_WEIGHTS R"("
dualpixel_person_weights_end:
  .popsection
)");
extern "C" {
[[gnu::visibility("hidden")]] extern const char dualpixel_person_weights_begin[];
[[gnu::visibility("hidden")]] extern const char dualpixel_person_weights_end[];
}

namespace dualpixel::pipeline {

const NetworkWeights& built_in_weights() {
  static const NetworkWeights weights =
      parse_weights({dualpixel_person_weights_begin,
                     static_cast<std::size_t>(dualpixel_person_weights_end - dualpixel_person_weights_begin)},
                    "built-in person weights");
  return weights;
}

}  // namespace dualpixel::pipeline

#else

namespace dualpixel::pipeline {

const NetworkWeights& built_in_weights() {
  throw InputError("person weights: this build has none; give a mask, or build with person.safetensors in place");
}

}  // namespace dualpixel::pipeline

#endif
