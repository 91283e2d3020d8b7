#include "formats/packed_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>

#include "formats/base/checks.h"
#include "formats/base/mapped_file.h"
#include "formats/base/regular_file.h"
#include "formats/base/stopping.h"
#include "formats/envelope/header.h"
#include "formats/envelope/seal.h"
#include "formats/format_error.h"

namespace rhoray::formats {

struct PackedFile::Mapping {
  std::string name;
  int descriptor = -1;
  std::optional<MappedFile> mapped;
  const std::byte* start = nullptr;
  std::uint64_t bytes = 0;

  std::string version;
  FileDescription description;
  std::vector<ArrayEntry> arrays;
  std::vector<const std::byte*> first_bytes;                 ///< of the arrays
  std::map<std::string, std::size_t, std::less<>> position;  ///< name to index in arrays
  std::shared_ptr<const void> owner{};                       ///< of arrays outside the file
  std::uint64_t header_bytes = 0;
  std::span<const std::uint64_t> sums;
  std::uint64_t summed_bytes = 0;  ///< starting at header_bytes

  Mapping(int owned_descriptor, std::string file_name);
  void add(const OutsideArray& outside);
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() { ::close(descriptor); }

  std::span<const std::byte> view(std::uint64_t first, std::uint64_t count) const { return {start + first, count}; }
  std::span<const std::byte> bytes_of(const ArrayEntry& array) const {
    return {first_bytes[static_cast<std::size_t>(&array - arrays.data())], array.byte_count};
  }

 private:
  void map();
  void read();
  std::uint64_t checked_header_bytes() const;
};

PackedFile::Mapping::Mapping(int owned_descriptor, std::string file_name)
    : name(std::move(file_name)), descriptor(owned_descriptor) {
  try {
    map();
    read();
    mapped->require_intact();
  } catch (...) {
    ::close(descriptor);
    throw;
  }
}

void PackedFile::Mapping::map() {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0)
    throw Error(ErrorCode::unreadable, concat(name, ": ", std::system_category().message(errno)));
  if (!S_ISREG(status.st_mode))
    throw Error(ErrorCode::unreadable,
                concat(name, ": found ", S_ISDIR(status.st_mode) ? "a folder" : "a special file", "; expected a file"));
  bytes = static_cast<std::uint64_t>(status.st_size);
  constexpr std::uint64_t smallest = envelope::page_bytes + envelope::seal_bytes;
  if (bytes < smallest)
    refuse(name, concat("byte ", bytes), "the end of the file",
           concat("a packed file of at least ", smallest, " bytes"));
  start = mapped.emplace(descriptor, bytes, name).bytes().data();
}

std::uint64_t PackedFile::Mapping::checked_header_bytes() const {
  std::uint64_t text_bytes = 0;
  std::memcpy(&text_bytes, start, envelope::length_bytes);
  // a huge length wraps to a small number
  const std::uint64_t whole = text_bytes + envelope::length_bytes;
  const std::uint64_t largest = std::min(envelope::largest_header_bytes, bytes - envelope::seal_bytes);
  if (text_bytes > largest || whole > largest || whole % envelope::page_bytes != 0)
    refuse(name, "byte 0", concat("a header length of ", text_bytes),
           concat("8 less than a multiple of 4096, at most ", largest - envelope::length_bytes));
  return whole;
}

void PackedFile::Mapping::read() {
  const std::string_view beginning(reinterpret_cast<const char*>(start) + envelope::length_bytes,
                                   envelope::start_text.size());
  if (beginning != envelope::start_text) throw Error(ErrorCode::invalid, concat(name, " is not a .rho file"));
  const std::span<const std::byte, envelope::seal_bytes> seal(start + (bytes - envelope::seal_bytes),
                                                              envelope::seal_bytes);
  envelope::check_seal_itself(name, seal, bytes);
  header_bytes = checked_header_bytes();
  envelope::check_sealed_header(name, seal, view(0, header_bytes));

  const std::string_view text(reinterpret_cast<const char*>(start) + envelope::length_bytes,
                              header_bytes - envelope::length_bytes);
  envelope::Header header = envelope::read_header(name, text, bytes - header_bytes);
  version = std::move(header.version);
  description = std::move(header.description);
  for (ArrayEntry& array : header.arrays) {
    array.first_byte += header_bytes;
    if (array.name == envelope::sums_name) {
      const std::span<const std::byte> raw = view(array.first_byte, array.byte_count);
      envelope::check_sealed_sums(name, seal, raw);
      sums = {reinterpret_cast<const std::uint64_t*>(raw.data()), raw.size() / sizeof(std::uint64_t)};
      summed_bytes = array.first_byte - header_bytes;
    }
    if (array.name.front() == '_') continue;  // array of the envelope
    position.emplace(array.name, arrays.size());
    first_bytes.push_back(start + array.first_byte);
    arrays.push_back(std::move(array));
  }
}

void PackedFile::Mapping::add(const OutsideArray& outside) {
  const ArraySpec& spec = outside.spec;
  ArrayEntry array{.name = spec.name, .type = spec.type, .shape = spec.shape, .byte_count = outside.bytes.size()};
  RHORAY_CHECK(array.element_count() * element_bytes(array.type) == array.byte_count);
  RHORAY_CHECK(reinterpret_cast<std::uintptr_t>(outside.bytes.data()) % element_bytes(array.type) == 0);
  RHORAY_CHECK(position.emplace(array.name, arrays.size()).second);
  first_bytes.push_back(outside.bytes.data());
  arrays.push_back(std::move(array));
}

PackedFile PackedFile::open(const std::filesystem::path& path) {
  // The kind of VdbGrid, which only passes between processes: its readers follow an unchecked tree.
  constexpr std::string_view never_on_disk = "vdb";
  PackedFile file(std::make_shared<const Mapping>(open_regular_file(path), path.string()));
  if (file.description().kind == never_on_disk)
    throw Error(ErrorCode::unsupported,
                concat(file.name(), ": kind '", never_on_disk, "'; expected 'colors', 'grid', 'surface' or 'tets'"));
  return file;
}

PackedFile PackedFile::from_descriptor(int descriptor, std::string name, std::span<const OutsideArray> outside,
                                       std::shared_ptr<const void> owner) {
  const int own = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  if (own < 0) throw Error(ErrorCode::unreadable, concat(name, ": ", std::system_category().message(errno)));
  const auto mapping = std::make_shared<Mapping>(own, std::move(name));
  for (const OutsideArray& array : outside) mapping->add(array);
  mapping->owner = std::move(owner);
  return PackedFile(mapping);
}

bool PackedFile::looks_packed(const std::filesystem::path& path) {
  constexpr std::size_t beginning_bytes = envelope::length_bytes + envelope::start_text.size();
  const std::string beginning = first_bytes(path, beginning_bytes);
  return beginning.size() == beginning_bytes && beginning.ends_with(envelope::start_text);
}

const std::string& PackedFile::name() const {
  return mapping_->name;
}
const std::string& PackedFile::version() const {
  return mapping_->version;
}
const FileDescription& PackedFile::description() const {
  return mapping_->description;
}
const std::vector<ArrayEntry>& PackedFile::arrays() const {
  return mapping_->arrays;
}
std::uint64_t PackedFile::file_bytes() const {
  return mapping_->bytes;
}

bool PackedFile::has(std::string_view array) const {
  return mapping_->position.contains(array);
}

const ArrayEntry& PackedFile::entry(std::string_view array) const {
  const auto found = mapping_->position.find(array);
  if (found == mapping_->position.end()) refuse(name(), concat("array '", array, "'"), "nothing", "that array");
  return mapping_->arrays[found->second];
}

std::span<const std::byte> PackedFile::bytes(std::string_view array) const {
  return mapping_->bytes_of(entry(array));
}

std::span<const std::byte> PackedFile::checked_bytes(std::string_view array, ElementType type,
                                                     std::span<const std::uint64_t> shape) const {
  const ArrayEntry& found = entry(array);
  const bool fits = std::equal(found.shape.begin(), found.shape.end(), shape.begin(), shape.end(),
                               [](std::uint64_t size, std::uint64_t wanted) { return wanted == 0 || size == wanted; });
  const auto text = [](ElementType of, std::span<const std::uint64_t> sizes, bool zero_is_any) {
    std::string list;
    for (const std::uint64_t size : sizes)
      list += concat(list.empty() ? "" : ", ", size == 0 && zero_is_any ? "any" : concat(size));
    return concat(element_name(of), " [", list, "]");
  };
  if (found.type != type || !fits)
    refuse(name(), concat("array '", array, "'"), text(found.type, found.shape, false), text(type, shape, true));
  return mapping_->bytes_of(found);
}

std::vector<DamagedBlock> PackedFile::damaged_blocks(unsigned threads, const Watch& watch) const {
  const Mapping& file = *mapping_;
  std::vector<DamagedBlock> damaged;
  std::mutex guard;
  const envelope::Stretch stretch{file.descriptor, file.header_bytes, file.summed_bytes};
  ProgressMeter meter(watch.progress, "comparing checksums (bytes)", file.summed_bytes);
  envelope::sum_blocks(stretch, threads, [&](std::uint64_t block, std::optional<std::uint64_t> sum) {
    end_if_stopped(watch.stop);
    const std::uint64_t at = block * envelope::block_bytes;
    const std::uint64_t bytes = std::min(envelope::block_bytes, file.summed_bytes - at);
    meter.add(bytes);
    if (sum == file.sums[block]) return;
    const std::lock_guard lock(guard);
    damaged.push_back({file.header_bytes + at, bytes});
  });
  std::sort(damaged.begin(), damaged.end(),
            [](const DamagedBlock& a, const DamagedBlock& b) { return a.first_byte < b.first_byte; });
  return damaged;
}

}  // namespace rhoray::formats
