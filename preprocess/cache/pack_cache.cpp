#include "preprocess/pack_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <system_error>
#include <thread>
#include <utility>

#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/pending_file.h"
#include "formats/base/regular_file.h"

namespace rhoray::preprocess {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::system_clock;

constexpr const char* record_extension = ".json";
constexpr const char* packed_extension = ".rho";
constexpr std::size_t largest_record = std::size_t{64} << 20;
/// A packed copy without a record is being written, or its writer was killed.
constexpr auto longest_writing = std::chrono::hours(24);
/// File systems use the kernel's coarse clock, which ticks every 1 to 10 ms.
constexpr std::int64_t settling_ns = 50'000'000;

std::int64_t ns_of(Clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

[[noreturn]] void refuse_folder(const fs::path& folder, const std::string& reason) {
  throw Error(ErrorCode::resource, concat(folder.string(), ": cannot be used as a cache: ", reason));
}

/// Makes a file name of sixteen hexadecimal digits. Two keys may share a name; the record tells
/// them apart.
std::string name_of(const PackCache::Key& key, const fs::path& input) {
  const std::size_t hash = std::hash<std::string>()(concat(input.string(), '\n', key.options, '\n', key.program));
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016zx", hash);
  return digits.data();
}

Json json_of_source(const SourceFile& source) {
  return {{"path", source.path.string()}, {"exists", source.exists}, {"device", source.device},
          {"inode", source.inode},        {"bytes", source.bytes},   {"changed_ns", source.changed_ns}};
}

SourceFile source_of(const Json& json) {
  return {.path = json.at("path").get<std::string>(),
          .exists = json.at("exists").get<bool>(),
          .device = json.at("device").get<std::uint64_t>(),
          .inode = json.at("inode").get<std::uint64_t>(),
          .bytes = json.at("bytes").get<std::uint64_t>(),
          .changed_ns = json.at("changed_ns").get<std::int64_t>()};
}

/// The facts of one packed copy, as its file in the cache holds them.
struct Record {
  fs::path input;
  std::string options, program;
  std::string packed;  ///< file name
  std::vector<SourceFile> sources;
  std::vector<std::string> notes;

  std::string text() const {
    Json json{{"input", input.string()}, {"options", options}, {"program", program}, {"packed", packed}};
    for (const SourceFile& source : sources) json["sources"].push_back(json_of_source(source));
    json["notes"] = notes;
    return dump_lines(json);
  }
};

/// Reads the facts of a packed copy; returns nothing for any other file.
std::optional<Record> read_record(const fs::path& path) {
  try {
    const Json json = Json::parse(first_bytes(path, largest_record));
    Record record{.input = json.at("input").get<std::string>(),
                  .options = json.at("options").get<std::string>(),
                  .program = json.at("program").get<std::string>(),
                  .packed = json.at("packed").get<std::string>(),
                  .sources = {},
                  .notes = json.at("notes").get<std::vector<std::string>>()};
    for (const Json& source : json.at("sources")) record.sources.push_back(source_of(source));
    if (fs::path(record.packed).filename() != record.packed) return std::nullopt;
    return record;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

bool are_unchanged(const std::vector<SourceFile>& sources) {
  return std::all_of(sources.begin(), sources.end(),
                     [](const SourceFile& source) { return source_file(source.path) == source; });
}

/// Opens a packed copy under the name of its input, for messages; returns nothing if it is missing
/// or damaged.
std::optional<formats::PackedFile> open_copy(const fs::path& path, const std::string& name) {
  try {
    const Descriptor file(open_regular_file(path));
    return formats::PackedFile::from_descriptor(file.number(), name);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Lists the files of the folder with this extension.
std::vector<fs::path> files_with(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == extension) files.push_back(entry.path());
  return files;
}

Clock::time_point time_of(const fs::path& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return {};
  return Clock::time_point(std::chrono::duration_cast<Clock::duration>(
      std::chrono::seconds(facts.st_mtim.tv_sec) + std::chrono::nanoseconds(facts.st_mtim.tv_nsec)));
}

/// Sets the time at which an entry was used. The kernel's own time stamps would not tell apart two
/// uses within one tick of its coarse clock.
void mark_used(const fs::path& record) {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  const std::array<timespec, 2> times{now, now};
  ::utimensat(AT_FDCWD, record.c_str(), times.data(), 0);
}

/// Waits until a further change would give the file another time.
void wait_until_settled(const SourceFile& source) {
  const std::int64_t age_ns = ns_of(Clock::now()) - source.changed_ns;
  if (source.exists && age_ns >= 0 && age_ns < settling_ns)
    std::this_thread::sleep_for(std::chrono::nanoseconds(settling_ns - age_ns));
}

/// Joins the input and the other files that packing read. Returns nothing if one of them may have
/// changed while it was read.
std::optional<std::vector<SourceFile>> settled(const SourceFile& input, std::vector<SourceFile> sources,
                                               std::int64_t start_ns) {
  sources.push_back(input);
  const auto by_path = [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; };
  std::stable_sort(sources.begin(), sources.end(), by_path);
  sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
  const auto share_a_path = [](const SourceFile& a, const SourceFile& b) { return a.path == b.path; };
  if (std::adjacent_find(sources.begin(), sources.end(), share_a_path) != sources.end()) return std::nullopt;
  for (const SourceFile& source : sources)
    if (source.exists && source.changed_ns > start_ns - settling_ns) return std::nullopt;
  return sources;
}

/// Waits until no other process changes the entries of the folder. Returns what holds the lock. On
/// a file system without locks, two processes may keep copies of one file; the older one goes after
/// longest_writing.
Descriptor lock_entries(const fs::path& folder) {
  Descriptor lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  while (lock.number() >= 0 && ::flock(lock.number(), LOCK_EX) != 0 && errno == EINTR) {
  }
  return lock;
}

/// An entry of the cache, and its two files.
struct Held {
  fs::path record, packed;
  PackCache::Entry entry;
};

/// Lists the entries of the folder, last used first. Removes old records without a packed copy; a
/// new one may belong to a process that is just replacing its copy.
std::vector<Held> held_in(const fs::path& folder) {
  std::vector<Held> all;
  for (const fs::path& path : files_with(folder, record_extension)) {
    const std::optional<Record> record = read_record(path);
    std::error_code missing, ignored;
    const std::uintmax_t bytes = record ? fs::file_size(folder / record->packed, missing) : 0;
    if (record && !missing)
      all.push_back({path, folder / record->packed, {record->input, record->options, bytes, time_of(path)}});
    else if (time_of(path) < Clock::now() - longest_writing)
      fs::remove(path, ignored);
  }
  std::sort(all.begin(), all.end(), [](const Held& a, const Held& b) { return a.entry.used > b.entry.used; });
  return all;
}

}  // namespace

fs::path PackCache::default_folder() {
  // A program that runs with the rights of another user ignores both variables.
  if (const char* xdg = ::secure_getenv("XDG_CACHE_HOME"); xdg != nullptr && fs::path(xdg).is_absolute())
    return fs::path(xdg) / "rhoray";
  if (const char* home = ::secure_getenv("HOME"); home != nullptr && fs::path(home).is_absolute())
    return fs::path(home) / ".cache" / "rhoray";
  return {};
}

PackCache::PackCache(fs::path folder, std::uint64_t limit_bytes)
    : folder_(std::move(folder)), limit_bytes_(limit_bytes) {
  if (folder_.empty()) throw Error(ErrorCode::resource, "no cache: neither XDG_CACHE_HOME nor HOME is set");
  std::error_code failed;
  fs::create_directories(folder_.parent_path(), failed);
  if (::mkdir(folder_.c_str(), 0700) != 0 && errno != EEXIST)
    refuse_folder(folder_, std::system_category().message(errno));
  const Descriptor opened(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.number() < 0) refuse_folder(folder_, std::system_category().message(errno));
  struct stat facts {};
  const bool is_own = ::fstat(opened.number(), &facts) == 0 && facts.st_uid == ::geteuid();
  const bool is_closed = is_own && ((facts.st_mode & 07777) == 0700 || ::fchmod(opened.number(), 0700) == 0);
  if (!is_own) refuse_folder(folder_, "it belongs to another user");
  if (!is_closed) refuse_folder(folder_, "its mode cannot be set to 0700");
}

std::optional<PackCache::Copy> PackCache::find(const Key& key) const {
  const fs::path input = source_file(key.input).path;
  const fs::path path = folder_ / (name_of(key, input) + record_extension);
  const std::optional<Record> record = read_record(path);
  if (!record || record->input != input || record->options != key.options || record->program != key.program ||
      !are_unchanged(record->sources))
    return std::nullopt;
  const fs::path packed = folder_ / record->packed;
  std::optional<formats::PackedFile> file = open_copy(packed, key.input.string());
  if (!file) return std::nullopt;
  mark_used(path);
  return Copy{.file = *std::move(file), .path = packed, .notes = record->notes, .sources = record->sources};
}

PackCache::Copy PackCache::add(const Key& key,
                               const std::function<PackReport(const formats::Destination&)>& write) const {
  SourceFile source = source_file(key.input);
  wait_until_settled(source);
  source = source_file(key.input);
  const Clock::time_point start = Clock::now();
  const std::string name = name_of(key, source.path);
  static std::atomic<std::uint64_t> count{0};
  const std::string packed = concat(name, '-', ns_of(start), '-', ::getpid(), '-', ++count, packed_extension);
  const PackReport report = write(formats::Destination(folder_ / packed));
  std::optional<formats::PackedFile> file = open_copy(folder_ / packed, key.input.string());
  if (!file) {  // another process has just cleared the cache
    if (std::optional<Copy> other = find(key)) return *std::move(other);
    throw Error(ErrorCode::resource, concat((folder_ / packed).string(), ": was removed at once"));
  }
  Copy copy{.file = *std::move(file), .path = folder_ / packed, .notes = report.notes, .sources = report.sources};
  std::error_code ignored;
  const auto drop = [&](const std::string& reason) {
    fs::remove(copy.path, ignored);
    copy.path.clear();
    copy.not_kept = reason;
    return copy;
  };
  const auto sources = settled(source, report.sources, ns_of(start));
  if (!sources) return drop("its files were changing");
  const Descriptor lock = lock_entries(folder_);
  if (std::optional<Copy> other = find(key)) {
    fs::remove(copy.path, ignored);
    return *std::move(other);
  }
  if (!fs::exists(copy.path, ignored)) return drop("another process has removed it");
  const fs::path record_path = folder_ / (name + record_extension);
  const std::optional<Record> old = read_record(record_path);
  const Record record{.input = source.path,
                      .options = key.options,
                      .program = key.program,
                      .packed = packed,
                      .sources = *sources,
                      .notes = report.notes};
  try {
    write_whole_file(record_path, record.text(), true);
  } catch (const Error& error) {
    return drop(error.what());
  }
  mark_used(record_path);
  if (old) fs::remove(folder_ / old->packed, ignored);
  shrink();
  return fs::exists(copy.path, ignored) ? copy : drop("it is larger than the cache");
}

std::vector<PackCache::Entry> PackCache::entries() const {
  std::vector<Entry> entries;
  for (const Held& held : held_in(folder_)) entries.push_back(held.entry);
  return entries;
}

std::vector<PackCache::Entry> PackCache::clear() const {
  std::error_code ignored;
  const Descriptor lock = lock_entries(folder_);
  std::vector<Entry> removed;
  for (const Held& held : held_in(folder_))
    if (fs::remove(held.packed, ignored)) removed.push_back(held.entry);
  for (const char* extension : {record_extension, packed_extension})
    for (const fs::path& path : files_with(folder_, extension)) fs::remove(path, ignored);
  return removed;
}

void PackCache::shrink() const {
  std::error_code ignored;
  std::vector<fs::path> orphans = files_with(folder_, packed_extension);
  std::uint64_t sum = 0;
  for (const Held& held : held_in(folder_)) {
    std::erase(orphans, held.packed);
    sum += held.entry.bytes;
    if (sum <= limit_bytes_) continue;
    fs::remove(held.record, ignored);
    fs::remove(held.packed, ignored);
    sum -= held.entry.bytes;
  }
  for (const fs::path& orphan : orphans)
    if (time_of(orphan) < Clock::now() - longest_writing) fs::remove(orphan, ignored);
}

}  // namespace rhoray::preprocess
