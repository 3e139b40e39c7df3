#pragma once
#include <cstddef>
#include <string>
#include <string_view>

/// Files and folders: only regular files are read, and nothing that is partly written ever has its final name. All
/// throw InputError with one line that names the path.
namespace dualpixel {

/// Throws where `path` is missing, or a folder, pipe or device (reading those could hang or never end).
void require_regular_file(const std::string& path);

inline constexpr std::size_t kLargestFileBytes = std::size_t{4} << 30;

/// ".exr" of "a/b.EXR": in lower case, empty where the name has none.
std::string extension_of(const std::string& path);

/// The bytes of a regular file of at most `most_bytes`.
std::string read_file(const std::string& path, std::size_t most_bytes = kLargestFileBytes);

/// XXH64 with seed 0 as 16 hexadecimal digits: detects changed bytes, not forgery.
std::string hash_of(std::string_view bytes);
std::string file_hash(const std::string& path);

/// Writes a new file and waits until the bytes have reached the disk.
void write_file(const std::string& path, std::string_view bytes);

/// Creates the missing parent folders of `path`.
void make_parents(const std::string& path);

/// Writes a file under a temporary name beside `path`, then renames it: `path` is the old file or the new, whole.
/// Missing parent folders are created.
void replace_file(const std::string& path, std::string_view bytes);

/// Throws where replace_file would, so that a command can fail before its work instead of after it.
void require_writable(const std::string& path);

/// Waits until a file's (or folder's) bytes have reached the disk.
void sync_to_disk(const std::string& path);

/// Prefix of the temporary siblings' names; a killed program may leave some.
inline constexpr std::string_view kTemporaryPrefix = ".dualpixel-";

/// Whether a folder can be read and has nothing in it, or only temporaries that killed programs have left.
bool holds_nothing(const std::string& folder);

/// A folder that is being written: a temporary sibling of its final path. commit() moves it there in one step; without
/// commit() the destructor removes it. Missing parent folders are created, and stay. An existing folder is replaced
/// where it is empty or holds the file `marker` ("capture.json"), which identifies it as this program's output, and
/// kept as its name and ".old" (".old2" and so on), with a warning, where it, or a folder within it, has anything by a
/// name that the new one lacks. Anything else is refused at construction.
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
  bool whole_ = false;  ///< under its final name
};

/// Throws where NewFolder would for what is there already; makes nothing.
void require_replaceable(const std::string& path, const std::string& marker);

/// The path to name in a message about `path`: the final one of a temporary, or of what lies in one.
std::string final_path(std::string path);

/// For a process that a signal or a limit ends: threads that would begin or finish an output wait for ever from now on.
void stop_outputs();

/// Removes the temporaries of NewFolder and replace_file in this process. After stop_outputs(), by the same thread.
void remove_unfinished_outputs();

}  // namespace dualpixel
