#include "datasets/state/tar.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "capture/error.h"
#include "capture/files.h"

namespace dualpixel::datasets {
namespace {

constexpr std::size_t kBlock = 512, kLongestName = 100;
constexpr std::uint64_t kLargestFile = 1ull << 33;  // eleven octal digits

struct Field {
  std::size_t offset, length;
};
constexpr Field kName{0, 100}, kMode{100, 8}, kOwner{108, 8}, kGroup{116, 8}, kSize{124, 12}, kTime{136, 12},
    kChecksum{148, 8}, kType{156, 1}, kMagic{257, 8};

std::array<char, kBlock> header_of(const std::string& name, std::uint64_t size) {
  std::array<char, kBlock> header{};
  const auto set = [&](const Field& field, const std::string& text) {
    std::copy_n(text.begin(), std::min(text.size(), field.length), header.begin() + static_cast<int>(field.offset));
  };
  set(kName, name);
  set(kMode, "0000644");
  set(kOwner, "0000000");
  set(kGroup, "0000000");
  set(kSize, fmt::format("{:011o}", size));
  set(kTime, "00000000000");
  set(kType, "0");
  set(kMagic, {"ustar\0"
               "00",
               8});
  set(kChecksum, "        ");  // counts as spaces
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  set(kChecksum, fmt::format("{:06o}", sum) + std::string("\0 ", 2));
  return header;
}

}  // namespace

TarFile::TarFile(const std::string& path) : path_(path), file_(path, std::ios::binary | std::ios::trunc) { write(""); }

void TarFile::add(const std::string& name, std::string_view bytes) {
  if (name.size() > kLongestName || bytes.size() >= kLargestFile) {
    throw std::logic_error("tar: " + name + ": a name or file that is too long");
  }
  const auto header = header_of(name, bytes.size());
  write({header.data(), header.size()});
  write(bytes);
  write(std::string((kBlock - bytes.size() % kBlock) % kBlock, '\0'));
}

void TarFile::close() {
  write(std::string(2 * kBlock, '\0'));
  file_.close();
  write("");
  sync_to_disk(path_);
}

void TarFile::write(std::string_view bytes) {
  if (!bytes.empty()) file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file_) throw InputError(printable(final_path(path_)) + ": cannot be written: is the disk full?");
  bytes_ += bytes.size();
}

}  // namespace dualpixel::datasets
