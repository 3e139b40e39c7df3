#include "scenes/people/data_set/mapped_array.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>

#include "capture/error.h"
#include "capture/files.h"

namespace dualpixel::scenes {
namespace {

constexpr std::size_t kMostItems = 1 << 24, kMostValuesOfAnItem = 1 << 30;

std::size_t bytes_of_type(const std::string& type) { return type == "|u1" ? 1 : 4; }

}  // namespace

MappedArray::MappedArray(const std::string& path) : path_(path) {
  require_regular_file(path);
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  const bool readable = file >= 0 && fstat(file, &status) == 0;
  file_bytes_ = static_cast<std::size_t>(status.st_size);
  void* const mapped =
      readable && file_bytes_ > 0 ? mmap(nullptr, file_bytes_, PROT_READ, MAP_PRIVATE, file, 0) : MAP_FAILED;
  if (file >= 0) close(file);
  if (!readable) throw InputError(printable(path_) + ": cannot be read");
  if (mapped == MAP_FAILED) throw InputError(printable(path_) + ": is empty, or cannot be mapped into memory");
  file_ = static_cast<const char*>(mapped);
  try {
    read_header();
  } catch (...) {
    munmap(mapped, file_bytes_);
    throw;
  }
}

void MappedArray::read_header() {
  const auto fail = [&](const std::string& why) { throw InputError(printable(path_) + ": " + why); };
  if (file_bytes_ < 10 || std::memcmp(file_, "\x93NUMPY\x01\x00", 8) != 0) fail("is no NumPy file of version 1");
  std::uint16_t header = 0;
  std::memcpy(&header, file_ + 8, 2);
  header_bytes_ = 10 + std::size_t{header};
  if (header_bytes_ > file_bytes_) fail("its header is cut off");
  if (header_bytes_ % 4 != 0) fail(fmt::format("its header ends at byte {}: must be a multiple of 4", header_bytes_));
  std::string_view rest(file_ + 10, header);
  const auto take = [&](std::string_view word) {
    const bool there = rest.starts_with(word);
    if (there) rest.remove_prefix(word.size());
    return there;
  };
  const auto take_size = [&] {
    std::size_t& size = shape_.emplace_back();
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), size);
    rest.remove_prefix(end - rest.data());
    return error == std::errc();
  };
  bool known = take("{'descr': '");
  const bool of_bytes = take("|u1");
  known = known && (of_bytes || take("<f4")) && take("', 'fortran_order': False, 'shape': (") && take_size();
  while (known && take(", ")) known = take_size();
  if (shape_.size() == 1) take(",");
  known = known && take("), }") && rest.find_first_not_of(" \n") == std::string_view::npos;
  if (!known) fail("its header is not that of a C-order array of uint8 or float32");
  type_ = of_bytes ? "|u1" : "<f4";
  if (shape_[0] > kMostItems) fail(fmt::format("{} items; at most {} are read", shape_[0], kMostItems));
  std::size_t values = 1;
  for (std::size_t i = 1; i < shape_.size(); ++i) {
    if (shape_[i] > kMostValuesOfAnItem / std::max<std::size_t>(values, 1)) {
      fail(fmt::format("shape ({}): items of more than {} values are not read", fmt::join(shape_, ", "),
                       kMostValuesOfAnItem));
    }
    values *= shape_[i];
  }
  item_bytes_ = values * bytes_of_type(type_);
  const std::size_t expected = header_bytes_ + shape_[0] * item_bytes_;
  if (expected != file_bytes_) fail(fmt::format("holds {} bytes; its header says {}", file_bytes_, expected));
}

MappedArray::~MappedArray() { munmap(const_cast<char*>(file_), file_bytes_); }

const std::uint8_t* MappedArray::bytes(std::size_t i) const {
  return reinterpret_cast<const std::uint8_t*>(file_ + header_bytes_ + i * item_bytes_);
}

const float* MappedArray::floats(std::size_t i) const { return reinterpret_cast<const float*>(bytes(i)); }

void MappedArray::require(const std::string& type, const std::vector<std::size_t>& rest) const {
  if (type_ == type && std::equal(shape_.begin() + 1, shape_.end(), rest.begin(), rest.end())) return;
  throw InputError(fmt::format("{}: '{}' values of shape ({}): must be '{}' of shape (N, {})", printable(path_), type_,
                               fmt::join(shape_, ", "), type, fmt::join(rest, ", ")));
}

}  // namespace dualpixel::scenes
