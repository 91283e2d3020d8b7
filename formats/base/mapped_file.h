#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace rhoray {

/// The bytes of a file, mapped for reading and entered in a table of all such mappings of the
/// process.
///
/// When somebody makes the file shorter, or a disk fails, reading the bytes that are gone raises
/// SIGBUS. This library installs no signal handler. A program may install one that calls
/// `replace_lost_bytes`: reading then goes on with zeros, the mapping counts as damaged, and
/// `require_intact` refuses what was computed from it.
class MappedFile {
 public:
  /// Maps the first `byte_count` bytes, at least 1. The descriptor stays the caller's and may be
  /// closed.
  /// @param name  for messages
  /// Refuses with ErrorCode::resource when the system cannot map them.
  MappedFile(int descriptor, std::uint64_t byte_count, std::string name);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return {start_, byte_count_}; }

  /// True when the loss of bytes is known already: pages that were read, or a size that was looked
  /// at. One load of an atomic flag.
  bool is_damaged() const noexcept;

  /// Throws (ErrorCode::invalid) when bytes were lost since the file was mapped. To be called when
  /// a result that was computed from these bytes is complete and before it is shown to anybody.
  void require_intact() const;

  /// The same for the mapping in which the address lies; an address in none is not refused.
  static void require_intact(const void* address);

 private:
  struct Entry;
  friend bool replace_lost_bytes(const void*) noexcept;
  friend void require_no_lost_bytes();

  // Under the table's mutex.
  static void require_intact(Entry& entry);
  static void look_at_size(Entry& entry);

  static Entry* enter(const std::byte* start, std::uint64_t byte_count, const std::string& name, int descriptor);

  /// of a list that is never freed: a handler may walk it at any time
  static std::atomic<Entry*> first_entry_;

  const std::byte* start_ = nullptr;
  std::uint64_t byte_count_ = 0;
  Entry* entry_ = nullptr;
};

/// For a program's handler of SIGBUS: when the address lies in a MappedFile, marks that file as
/// damaged and maps zeros over its bytes from the address's page to the end, so that reading can go
/// on. Safe to call in a signal handler and from several threads.
/// @return  false when the address lies in no MappedFile or zeros cannot be mapped; nothing was
///          changed then
bool replace_lost_bytes(const void* address) noexcept;

/// True when `replace_lost_bytes` has replaced bytes since the process started. Safe in a signal
/// handler.
bool any_bytes_lost() noexcept;

/// Throws (ErrorCode::invalid) for a file that lost bytes and for which no
/// MappedFile::require_intact has thrown yet, also when its mapping is gone by now. To be called
/// before anything is published.
void require_no_lost_bytes();

}  // namespace rhoray
