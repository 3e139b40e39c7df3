#pragma once
#include <cstddef>
#include <string>
#include <string_view>

/// Files and folders, so that nothing is read that is no regular file and nothing half-written is ever left under its
/// final name. All throw InputError with one line that names the path.
namespace dualpixel {

/// Refuses what is missing, a folder, a pipe or a device (reading those would hang or never end).
void require_regular_file(const std::string& path);

inline constexpr std::size_t kLargestFileBytes = std::size_t{4} << 30;

/// The bytes of a regular file of at most `most_bytes`.
std::string read_file(const std::string& path, std::size_t most_bytes = kLargestFileBytes);

/// XXH64 with seed 0 as 16 hexadecimal digits: tells whether bytes changed, not whether somebody forged them.
std::string hash_of(std::string_view bytes);
std::string file_hash(const std::string& path);

/// Writes a new file and waits until the bytes have reached the disk.
void write_file(const std::string& path, std::string_view bytes);

/// Makes the folders that `path` is to lie in, where they are missing.
void make_parents(const std::string& path);

/// Writes a file under a temporary name beside `path`, then renames it: `path` is the old file or the new, whole.
/// Missing folders on the way are made, as `mkdir -p` does.
void replace_file(const std::string& path, std::string_view bytes);

/// Throws what replace_file would, before the work whose result it is to write.
void require_writable(const std::string& path);

/// Waits until a file's (or folder's) bytes have reached the disk.
void sync_to_disk(const std::string& path);

/// How the names of the temporary siblings begin, which a killed program may leave.
inline constexpr std::string_view kTemporaryPrefix = ".dualpixel-";

/// A folder while it is being written. It lives as a temporary sibling of its final place: commit() moves it there in
/// one step; without commit() the destructor removes it. Missing folders on the way are made, and stay. What stood
/// there before is replaced where it is an empty folder, or a folder that holds the file `marker` ("capture.json"),
/// which tells that it is one of ours; anything else is refused at construction.
class NewFolder {
 public:
  NewFolder(const std::string& final_path, const std::string& marker);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  /// Where to write until commit().
  const std::string& path() const { return temporary_; }
  void commit();

 private:
  std::string final_;
  std::string marker_;
  std::string temporary_;
};

/// Removes what NewFolder and replace_file have under way in this process: for a program that a signal ends.
void remove_unfinished_outputs();

}  // namespace dualpixel
