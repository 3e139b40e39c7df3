#include "capture/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>

#include "capture/error.h"

namespace dualpixel {
namespace {

namespace fs = std::filesystem;

/// Temporary paths in use and their final paths: for remove_unfinished_outputs() and for messages.
std::mutex unfinished_mutex;
std::map<std::string, std::string> unfinished;

}  // namespace

std::string extension_of(const std::string& path) {
  std::string extension = fs::path(path).extension();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

std::string final_path(std::string path) {
  const std::lock_guard lock(unfinished_mutex);
  // backwards: a temporary within a temporary before the outer one
  for (auto entry = unfinished.rbegin(); entry != unfinished.rend(); ++entry) {
    const auto& [temporary, final] = *entry;
    if (path.starts_with(temporary)) path = final + path.substr(temporary.size());
  }
  return path;
}

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw InputError(printable(final_path(path)) + ": " + why);
}

[[noreturn]] void fail_errno(const std::string& path, const std::string& what) {
  const int error = errno;
  fail(path, what + ": " + std::strerror(error));
}

void forget(const std::string& temporary) {
  const std::lock_guard lock(unfinished_mutex);
  unfinished.erase(temporary);
}

/// Gives what is whole its final name. Not after stop_outputs().
int finish(const std::string& temporary, const std::string& final, unsigned flags) {
  const std::lock_guard lock(unfinished_mutex);
  const int status = renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, final.c_str(), flags);
  if (status == 0 && flags != RENAME_EXCHANGE) unfinished.erase(temporary);
  return status;
}

/// A name beside `path` that no other process or thread uses, nor one of the same number has left. Short, whatever the
/// length of the final name.
std::string temporary_sibling(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  for (;;) {
    const std::string name = fmt::format("{}{}-{}.tmp", kTemporaryPrefix, getpid(), counter++);
    const fs::path sibling = fs::path(path).parent_path() / name;
    std::error_code error;
    if (!fs::exists(fs::symlink_status(sibling, error))) return sibling.string();
  }
}

/// An absolute path without links, dots or a trailing slash.
std::string resolve(const std::string& path) {
  std::error_code error;
  fs::path resolved = fs::weakly_canonical(fs::absolute(path, error), error);
  if (path.empty()) throw InputError("the name of an output is empty");
  if (error) fail(path, "cannot be written: " + error.message());
  if (!resolved.has_filename()) resolved = resolved.parent_path();
  return resolved.string();
}

}  // namespace

void require_replaceable(const std::string& path, const std::string& marker) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (status.type() == fs::file_type::not_found) return;
  if (!fs::is_directory(status)) fail(path, "exists and is not a folder");
  if (fs::is_regular_file(fs::path(path) / marker, error)) return;
  const bool empty = fs::is_empty(path, error);
  if (error) fail(path, "cannot be read: " + error.message());
  if (!empty) fail(path, "exists, and is neither empty nor holds " + marker + ": it will not be overwritten");
}

namespace {

/// Whether a folder, or one within it, has anything by a name that the one lacks that is to replace it, but for what
/// `score` writes into results.
bool holds_what_is_not_in(const fs::path& replaced, const fs::path& replacing) {
  std::error_code error, ignored;
  fs::directory_iterator entry(replaced, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const fs::path name = entry->path().filename();
    if (name == "score.json") continue;
    const fs::file_type type = entry->symlink_status(ignored).type();
    if (fs::symlink_status(replacing / name, ignored).type() != type) return true;
    if (type == fs::file_type::directory && holds_what_is_not_in(entry->path(), replacing / name)) return true;
  }
  if (error && error != std::errc::no_such_file_or_directory) fail(replaced, "cannot be read: " + error.message());
  return false;
}

/// Gives what is whole its final name, and the folder that had it the name FINAL.old, or FINAL.old2 and so on where
/// there is one, which is returned; nothing, with errno, where that fails. What is whole takes that name first, then
/// the two are exchanged, so that neither is without a name at any moment. Not after stop_outputs().
std::optional<std::string> finish_and_keep(const std::string& temporary, const std::string& final) {
  const std::lock_guard lock(unfinished_mutex);
  const auto move = [](const std::string& from, const std::string& to, unsigned flags) {
    return renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) == 0;
  };
  std::string kept = final + ".old";
  for (int number = 2; !move(temporary, kept, RENAME_NOREPLACE); ++number) {
    if (errno != EEXIST) return {};
    kept = fmt::format("{}.old{}", final, number);
  }
  if (!move(kept, final, RENAME_EXCHANGE)) {
    const int error = errno;
    move(kept, temporary, RENAME_NOREPLACE);
    errno = error;
    return {};
  }
  unfinished.erase(temporary);
  return kept;
}

/// Where replace_file is to write `path`: there is a folder for it, and no folder or device in its place.
std::string replaceable_file(const std::string& path) {
  std::string target = resolve(path);
  std::error_code error;
  if (fs::exists(target, error) && !fs::is_regular_file(target, error)) fail(path, "exists and is not a regular file");
  make_parents(target);
  return target;
}

}  // namespace

bool holds_nothing(const std::string& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder, error);
  return !error && std::all_of(begin(entries), end(entries), [](const fs::directory_entry& entry) {
    return entry.path().filename().string().starts_with(kTemporaryPrefix);
  });
}

void require_regular_file(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) fail(path, "no such file");
  if (error) fail(path, "cannot be read: " + error.message());
  if (!fs::is_regular_file(status)) {
    fail(path, fs::is_directory(status) ? "is a folder, not a file" : "is not a regular file");
  }
}

std::string read_file(const std::string& path, std::size_t most_bytes) {
  require_regular_file(path);
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) fail_errno(path, "cannot be read");
  const auto size = static_cast<std::size_t>(file.tellg());
  if (size > most_bytes) fail(path, fmt::format("{} bytes; at most {} are read", size, most_bytes));
  std::string bytes(size, '\0');
  file.seekg(0);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) fail(path, "cannot be read to its end");
  return bytes;
}

std::string hash_of(std::string_view bytes) { return fmt::format("{:016x}", XXH64(bytes.data(), bytes.size(), 0)); }

std::string file_hash(const std::string& path) { return hash_of(read_file(path)); }

void sync_to_disk(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail_errno(path, "cannot be written");
  // Some file systems cannot sync a folder and say EINVAL; there is then nothing more to do.
  const bool failed = fsync(descriptor) != 0 && errno != EINVAL;
  close(descriptor);
  if (failed) fail(path, "cannot be written to the disk");
}

void write_file(const std::string& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) fail_errno(path, "cannot be written");
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) fail_errno(path, "cannot be written");
  sync_to_disk(path);
}

void make_parents(const std::string& path) {
  const fs::path parent = fs::absolute(path).parent_path();
  std::error_code error;
  fs::create_directories(parent, error);
  if (!fs::is_directory(parent, error)) {
    fail(path, "cannot be written: " + printable(parent.string()) + " cannot be made a folder");
  }
}

void replace_file(const std::string& path, std::string_view bytes) {
  const std::string target = replaceable_file(path);
  const std::string temporary = temporary_sibling(target);
  {
    const std::lock_guard lock(unfinished_mutex);
    unfinished.emplace(temporary, path);
  }
  try {
    write_file(temporary, bytes);
    if (finish(temporary, target, 0) != 0) fail_errno(path, "cannot be written");
  } catch (...) {
    std::error_code error;
    fs::remove(temporary, error);
    forget(temporary);
    throw;
  }
}

void require_writable(const std::string& path) {
  const std::string probe = temporary_sibling(replaceable_file(path));
  const auto make = [&] {
    const std::lock_guard lock(unfinished_mutex);
    return mkdir(probe.c_str(), 0777) == 0 && rmdir(probe.c_str()) == 0;
  };
  if (!make()) fail_errno(path, "cannot be written");
}

NewFolder::NewFolder(const std::string& final_path, const std::string& marker)
    : final_(resolve(final_path)), marker_(marker) {
  require_replaceable(final_, marker_);
  make_parents(final_);
  do {
    temporary_ = temporary_sibling(final_);
    const std::lock_guard lock(unfinished_mutex);
    const auto entry = unfinished.emplace(temporary_, final_path).first;  // before the folder: memory may end here
    if (mkdir(temporary_.c_str(), 0777) == 0) return;
    const int error = errno;
    unfinished.erase(entry);
    errno = error;
  } while (errno == EEXIST);
  fail_errno(final_path, "cannot be written");
}

NewFolder::~NewFolder() {
  if (temporary_.empty()) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
  // What is whole need not wait for others after stop_outputs(): its process may end.
  if (!whole_) {
    forget(temporary_);
  } else if (unfinished_mutex.try_lock()) {
    unfinished.erase(temporary_);
    unfinished_mutex.unlock();
  }
}

void NewFolder::commit() {
  sync_to_disk(temporary_);
  require_replaceable(final_, marker_);
  std::optional<std::string> kept;
  if (holds_what_is_not_in(final_, temporary_)) {
    kept = finish_and_keep(temporary_, final_);
    if (!kept) fail_errno(final_, "has files that would be lost, and cannot be replaced");
    temporary_.clear();
  } else if (finish(temporary_, final_, 0) == 0) {
    temporary_.clear();
  } else if ((errno != ENOTEMPTY && errno != EEXIST) || finish(temporary_, final_, RENAME_EXCHANGE) != 0) {
    fail_errno(final_, "cannot be replaced");
  }
  whole_ = true;
  // After an exchange the old folder stands under the temporary name, and the destructor removes it.
  sync_to_disk(fs::path(final_).parent_path().string());
  if (!kept) return;
  std::cerr << fmt::format("dualpixel: warning: {}: held files that are not replaced: they are kept in {}\n",
                           printable(final_), printable(*kept));
}

void stop_outputs() { unfinished_mutex.lock(); }

void remove_unfinished_outputs() {
  for (const auto& [temporary, final] : unfinished) {
    // Threads that still write may put a new file into a folder that is just being emptied: try again.
    std::error_code error;
    for (int attempt = 0; attempt < 50; ++attempt) {
      fs::remove_all(temporary, error);
      if (!fs::exists(temporary, error)) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
}

}  // namespace dualpixel
