#include "simulator/scene/paged_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "capture/error.h"

namespace dualpixel::simulator {
namespace {

struct File {
  int descriptor = -1;
  ~File() {
    if (descriptor >= 0) close(descriptor);
  }
};

}  // namespace

std::shared_ptr<std::uint8_t[]> paged_bytes(std::size_t size) {
  const char* chosen = std::getenv("TMPDIR");
  const std::string folder = chosen && *chosen ? chosen : "/tmp";
  const auto fail = [&](int error) {
    throw InputError(fmt::format("{}: cannot hold {} bytes of textures: {}: set TMPDIR to a folder that can",
                                 printable(folder), size, std::strerror(error)));
  };
  std::string path = folder + "/dualpixel-XXXXXX";
  const File file{mkstemp(path.data())};
  if (file.descriptor < 0) fail(errno);
  unlink(path.c_str());  // the file goes with the last that holds it, however the program ends
  if (const int error = posix_fallocate(file.descriptor, 0, static_cast<off_t>(size))) fail(error);
  void* bytes = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor, 0);
  if (bytes == MAP_FAILED) fail(errno);
  return {static_cast<std::uint8_t*>(bytes), [size](std::uint8_t* p) { munmap(p, size); }};
}

}  // namespace dualpixel::simulator
