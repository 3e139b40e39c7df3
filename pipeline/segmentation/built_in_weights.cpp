#include "capture/error.h"
#include "pipeline/segmentation/weights.h"

#if defined(DUALPIXEL_PERSON_WEIGHTS) && defined(DUALPIXEL_FACE_WEIGHTS)

// The files, unchanged, in the library's read-only data.
asm(R"(
  .pushsection .rodata
  .globl dualpixel_person_weights_begin, dualpixel_person_weights_end
  .hidden dualpixel_person_weights_begin, dualpixel_person_weights_end
  .globl dualpixel_face_weights_begin, dualpixel_face_weights_end
  .hidden dualpixel_face_weights_begin, dualpixel_face_weights_end
  .balign 16
dualpixel_person_weights_begin:
  .incbin ")" DUALPIXEL_PERSON_WEIGHTS R"("
dualpixel_person_weights_end:
  .balign 16
dualpixel_face_weights_begin:
  .incbin ")" DUALPIXEL_FACE_WEIGHTS R"("
dualpixel_face_weights_end:
  .popsection
)");
extern "C" {
[[gnu::visibility("hidden")]] extern const char dualpixel_person_weights_begin[];
[[gnu::visibility("hidden")]] extern const char dualpixel_person_weights_end[];
[[gnu::visibility("hidden")]] extern const char dualpixel_face_weights_begin[];
[[gnu::visibility("hidden")]] extern const char dualpixel_face_weights_end[];
}

namespace dualpixel::pipeline {
namespace {

NetworkWeights parse(const char* begin, const char* end, const char* name, NetworkKind kind) {
  return parse_weights({begin, static_cast<std::size_t>(end - begin)}, name, kind);
}

}  // namespace

const NetworkWeights& built_in_weights(NetworkKind kind) {
  static const NetworkWeights person = parse(dualpixel_person_weights_begin, dualpixel_person_weights_end,
                                             "built-in person weights", NetworkKind::person);
  static const NetworkWeights faces =
      parse(dualpixel_face_weights_begin, dualpixel_face_weights_end, "built-in face weights", NetworkKind::faces);
  return kind == NetworkKind::person ? person : faces;
}

}  // namespace dualpixel::pipeline

#else

namespace dualpixel::pipeline {

const NetworkWeights& built_in_weights(NetworkKind) {
  throw InputError(
      "person and face weights: this build has none; give a mask, or build with both files of pipeline/segmentation/"
      "weights in place");
}

}  // namespace dualpixel::pipeline

#endif
