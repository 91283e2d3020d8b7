#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace rhoray {

/// The bytes of a file, mapped for reading. All mappings of the process are registered in one
/// table.
///
/// If somebody shortens the file, or a disk fails, reading the lost bytes raises SIGBUS. This
/// library installs no signal handler. A program may install one that calls `replace_lost_bytes`.
/// Reading then continues with zeros, the mapping counts as damaged, and `require_intact` refuses
/// results computed from it.
class MappedFile {
 public:
  /// Maps the first `byte_count` bytes, at least 1. The descriptor still belongs to the caller and
  /// may be closed. Refuses with ErrorCode::resource when the system cannot map the bytes.
  /// @param name  for messages
  MappedFile(int descriptor, std::uint64_t byte_count, std::string name);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return {start_, byte_count_}; }

  /// True when a loss of bytes is already known, from reading pages or from checking the size.
  /// Costs one load of an atomic flag.
  bool is_damaged() const noexcept;

  /// Throws (ErrorCode::invalid) when bytes were lost since the file was mapped. Call it when a
  /// result computed from these bytes is complete and before anybody sees it.
  void require_intact() const;

  /// The same for the mapping that contains the address; does nothing if no mapping contains it.
  static void require_intact(const void* address);

 private:
  struct Entry;
  friend bool replace_lost_bytes(const void*) noexcept;
  friend void require_no_lost_bytes();

  // Call these with the table's mutex held.
  static void require_intact(Entry& entry);
  static void look_at_size(Entry& entry);

  static Entry* enter(const std::byte* start, std::uint64_t byte_count, const std::string& name, int descriptor);

  /// head of a list that is never freed: a signal handler may walk it at any time
  static std::atomic<Entry*> first_entry_;

  const std::byte* start_ = nullptr;
  std::uint64_t byte_count_ = 0;
  Entry* entry_ = nullptr;
};

/// For a program's SIGBUS handler. If the address lies in a MappedFile, marks that file as damaged
/// and maps zeros over its bytes, from the address's page to the end. Reading can then continue.
/// Safe in a signal handler and from several threads.
/// @return  false, with nothing changed, when the address lies in no MappedFile or zeros cannot be
///          mapped
bool replace_lost_bytes(const void* address) noexcept;

/// True when `replace_lost_bytes` has replaced bytes since the process started. Safe in a signal
/// handler.
bool any_bytes_lost() noexcept;

/// Throws (ErrorCode::invalid) if a file has lost bytes and no MappedFile::require_intact has
/// thrown for it yet, even if its mapping no longer exists. Call it before publishing anything.
void require_no_lost_bytes();

}  // namespace rhoray
