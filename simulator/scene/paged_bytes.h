#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

namespace dualpixel::simulator {

/// `size` zeros, at least one, in a file without a name in the folder for temporary files (TMPDIR, else /tmp), which
/// the system pages in and out: memory holds what is used, as long as nothing else needs it. Throws InputError
/// where that folder cannot hold them.
std::shared_ptr<std::uint8_t[]> paged_bytes(std::size_t size);

}  // namespace dualpixel::simulator
