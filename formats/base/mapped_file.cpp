#include "formats/base/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <mutex>
#include <system_error>

#include "formats/base/checks.h"
#include "formats/base/error.h"

namespace rhoray {

/// One mapping. Entries form a list that only grows, and entries of removed mappings are reused. So
/// a signal handler may walk the list at any time.
struct MappedFile::Entry {
  std::atomic<std::uint64_t> version{0};  ///< odd while start and byte_count change
  std::atomic<std::uintptr_t> start{0};
  std::atomic<std::uint64_t> byte_count{0};  ///< 0: free
  std::atomic<bool> damaged{false};
  std::string name;       ///< guarded by the table's mutex, like the next three
  bool reported = false;  ///< an exception has reported the damage
  bool is_mapped = false;
  int descriptor = -1;    ///< of the mapped file; -1 if the process had no descriptor left
  Entry* next = nullptr;  ///< set once, before the entry joins the list

  void set(std::uintptr_t new_start, std::uint64_t new_count) {
    version.fetch_add(1);
    start.store(new_start);
    byte_count.store(new_count);
    version.fetch_add(1);
  }
};

namespace {

std::mutex table_mutex;
std::atomic<bool> bytes_lost{false};
const auto page_bytes = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));

static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "a signal handler may wait for no lock");

Error loss(const std::string& name) {
  return {ErrorCode::invalid,
          concat(name, ": lost bytes while it was read: another program made it shorter, or its disk failed")};
}

}  // namespace

/// If a shortened file lacks bytes only inside its last page, they read as zeros without a signal.
/// Its size reveals the loss.
void MappedFile::look_at_size(Entry& entry) {
  struct stat status {};
  if (!entry.is_mapped || entry.descriptor < 0 || ::fstat(entry.descriptor, &status) != 0) return;
  if (static_cast<std::uint64_t>(status.st_size) >= entry.byte_count) return;
  entry.damaged.store(true);
  bytes_lost.store(true);
}

constinit std::atomic<MappedFile::Entry*> MappedFile::first_entry_{nullptr};

MappedFile::Entry* MappedFile::enter(const std::byte* start, std::uint64_t byte_count, const std::string& name,
                                     int descriptor) {
  const std::lock_guard lock(table_mutex);
  Entry* const first = first_entry_.load();
  Entry* entry = first;
  // Keep the name of a loss that has not been reported.
  while (entry != nullptr && (entry->is_mapped || (entry->damaged && !entry->reported))) entry = entry->next;
  const bool is_new = entry == nullptr;
  if (is_new) {
    entry = new Entry;
    entry->next = first;
  }
  entry->name = name;
  entry->reported = false;
  entry->is_mapped = true;
  entry->descriptor = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  entry->damaged = false;
  entry->set(reinterpret_cast<std::uintptr_t>(start), byte_count);
  if (is_new) first_entry_.store(entry);
  return entry;
}

MappedFile::MappedFile(int descriptor, std::uint64_t byte_count, std::string name) : byte_count_(byte_count) {
  RHORAY_CHECK(byte_count > 0);
  // Private, because files in memory that are sealed against writing allow no other mapping.
  // Nothing is written or copied.
  void* const start = ::mmap(nullptr, byte_count, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (start == MAP_FAILED)
    throw Error(ErrorCode::resource,
                concat(name, ": cannot map ", byte_count, " bytes: ", std::system_category().message(errno)));
  start_ = static_cast<const std::byte*>(start);
  try {
    entry_ = enter(start_, byte_count, name, descriptor);
  } catch (...) {
    ::munmap(start, byte_count);
    throw;
  }
}

MappedFile::~MappedFile() {
  {
    const std::lock_guard lock(table_mutex);
    entry_->set(0, 0);  // before the system can reuse the addresses
    entry_->is_mapped = false;
    if (entry_->descriptor >= 0) ::close(entry_->descriptor);
    entry_->descriptor = -1;
  }
  ::munmap(const_cast<std::byte*>(start_), byte_count_);
}

bool MappedFile::is_damaged() const noexcept {
  return entry_->damaged.load();
}

void MappedFile::require_intact(Entry& entry) {
  look_at_size(entry);
  if (!entry.damaged) return;
  entry.reported = true;
  throw loss(entry.name);
}

void MappedFile::require_intact() const {
  const std::lock_guard lock(table_mutex);
  require_intact(*entry_);
}

void MappedFile::require_intact(const void* address) {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  const std::lock_guard lock(table_mutex);
  for (Entry* entry = first_entry_.load(); entry != nullptr; entry = entry->next)
    if (entry->is_mapped && at - entry->start < entry->byte_count) return require_intact(*entry);
}

bool replace_lost_bytes(const void* address) noexcept {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  for (MappedFile::Entry* entry = MappedFile::first_entry_.load(); entry != nullptr; entry = entry->next) {
    // The entry of the mapping being read cannot change; an entry that changes belongs to another.
    const std::uint64_t version = entry->version.load();
    const std::uintptr_t start = entry->start.load();
    const std::uint64_t byte_count = entry->byte_count.load();
    if (version % 2 != 0 || entry->version.load() != version) continue;
    const std::uint64_t mapped_bytes = (byte_count + page_bytes - 1) / page_bytes * page_bytes;
    if (byte_count == 0 || at < start || at - start >= mapped_bytes) continue;

    entry->damaged.store(true);  // before anybody can read zeros
    bytes_lost.store(true);
    const std::uintptr_t page = at / page_bytes * page_bytes;
    return ::mmap(reinterpret_cast<void*>(page), start + mapped_bytes - page, PROT_READ,
                  MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED | MAP_NORESERVE, -1, 0) != MAP_FAILED;
  }
  return false;
}

bool any_bytes_lost() noexcept {
  return bytes_lost.load();
}

void require_no_lost_bytes() {
  const std::lock_guard lock(table_mutex);
  for (MappedFile::Entry* entry = MappedFile::first_entry_.load(); entry != nullptr; entry = entry->next) {
    MappedFile::look_at_size(*entry);
    if (!entry->damaged || entry->reported) continue;
    entry->reported = true;
    throw loss(entry->name);
  }
}

}  // namespace rhoray
