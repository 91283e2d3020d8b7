#pragma once

#include <cstdint>

namespace rhoray::tests {

/// The effect of a recorded call on the folder.
enum class CallKind : std::uint32_t {
  create,    ///< a file was created; it has a name unless it is anonymous
  write,     ///< writes `bytes` from byte `at` on
  resize,    ///< the file has `at` bytes now
  map,       ///< the file was mapped so that it can be written through memory
  link,      ///< the file got a name
  rename,    ///< `name` became `second_name`
  exchange,  ///< `name` and `second_name` were exchanged
  unlink,    ///< `name` was removed
  /// The changes of the file by calls within the first `at` bytes of the record are durable.
  flush_file,
  /// The changes of names by calls within the first `at` bytes of the record are durable.
  flush_folder,
};

/// Begins a call in the record that recorded_calls_preload.cpp writes. The two names and the bytes
/// follow, without zeros between them.
struct CallHeader {
  CallKind kind = CallKind::create;
  std::uint32_t name_bytes = 0;
  std::uint32_t second_name_bytes = 0;
  std::uint32_t unused = 0;
  std::uint64_t file = 0;  ///< inode number
  std::uint64_t at = 0;
  std::uint64_t byte_count = 0;
};

}  // namespace rhoray::tests
