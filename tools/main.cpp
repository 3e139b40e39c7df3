#include <unistd.h>

#include <cstdio>

#include "tools/cli/exit_status.h"
#include "tools/cli/program.h"

namespace {

#if defined(__x86_64__) && defined(__AVX2__)
/// Runs before any static initializer, which may already hold an instruction that an older processor lacks.
[[gnu::constructor(101)]] void require_avx2() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) return;
  std::fputs("dualpixel: this build needs a processor with AVX2; build with -DDUALPIXEL_ARCH=x86-64 instead\n", stderr);
  _exit(dualpixel::tools::kInternalError);
}
#endif

}  // namespace

int main(int argc, char** argv) { return dualpixel::tools::program_main(argc, argv); }
