#include <algorithm>
#include <atomic>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "formats/envelope/header.h"
#include "formats/envelope/seal.h"
#include "formats/packed_file.h"

namespace rhoray::formats {
namespace {

/// The bytes of an array that have been written.
class Coverage {
 public:
  /// Adds [first, last). False when one of its bytes was already written.
  bool take(std::uint64_t first, std::uint64_t last) {
    if (first == last) return true;
    auto next = runs_.lower_bound(first);
    if (next != runs_.end() && next->first < last) return false;
    if (next != runs_.begin()) {
      const auto previous = std::prev(next);
      if (previous->second > first) return false;
      if (previous->second == first) {  // extend the run instead of starting a new one
        first = previous->first;
        runs_.erase(previous);
      }
    }
    if (next != runs_.end() && next->first == last) {
      last = next->second;
      runs_.erase(next);
    }
    runs_.emplace(first, last);
    return true;
  }

  /// The first byte of [0, count) that was not written; count when all were written.
  std::uint64_t first_missing(std::uint64_t count) const {
    if (runs_.empty() || runs_.begin()->first != 0) return 0;
    return std::min(runs_.begin()->second, count);
  }

 private:
  std::map<std::uint64_t, std::uint64_t> runs_;  ///< start -> end; runs do not touch
};

}  // namespace

struct PackedFileWriter::State {
  State(std::unique_ptr<PendingFile> pending, const FileDescription& description, const std::vector<ArraySpec>& specs)
      : file(std::move(pending)),
        arrays(envelope::place_arrays(file->name(), specs)),
        header(envelope::write_header(file->name(), description, arrays)),
        file_bytes(header.size() + arrays.back().first_byte + arrays.back().byte_count),
        coverage(arrays.size()) {
    for (std::size_t i = 0; i < arrays.size(); ++i) position.emplace(arrays[i].name, i);
    file->reserve(file_bytes);
  }

  std::uint64_t start(const ArrayEntry& array) const { return header.size() + array.first_byte; }
  void check_coverage() const;
  std::vector<std::uint64_t> sums(unsigned threads) const;

  std::unique_ptr<PendingFile> file;
  /// with padding, sums and seal; first_byte counts from the start of the data area
  std::vector<ArrayEntry> arrays;
  std::string header;
  std::uint64_t file_bytes = 0;
  std::map<std::string, std::size_t, std::less<>> position;
  std::mutex guard;
  std::vector<Coverage> coverage;
  std::atomic<bool> failed{false};
};

PackedFileWriter::PackedFileWriter(const Destination& destination, const FileDescription& description,
                                   const std::vector<ArraySpec>& arrays, Options options)
    : state_(std::make_unique<State>(
          destination.descriptor >= 0
              ? std::make_unique<PendingFile>(destination.descriptor)
              : std::make_unique<PendingFile>(destination.path,
                                              PendingFile::Options{.replace_existing = options.replace_existing}),
          description, arrays)) {}

PackedFileWriter::PackedFileWriter(PackedFileWriter&&) noexcept = default;
PackedFileWriter& PackedFileWriter::operator=(PackedFileWriter&&) noexcept = default;
PackedFileWriter::~PackedFileWriter() = default;

void PackedFileWriter::write(std::string_view array, std::uint64_t byte_offset, std::span<const std::byte> bytes) {
  RHORAY_CHECK(state_ != nullptr);  // nothing can be written after commit
  State& state = *state_;
  const auto found = state.position.find(array);
  if (found == state.position.end() || array.starts_with('_'))
    throw Error(ErrorCode::internal, concat(state.file->name(), ": array '", array, "' was not declared"));
  const ArrayEntry& entry = state.arrays[found->second];
  if (byte_offset > entry.byte_count || bytes.size() > entry.byte_count - byte_offset)
    throw Error(ErrorCode::internal, concat(state.file->name(), ", array '", array, "': bytes ", byte_offset, " to ",
                                            byte_offset + bytes.size(), " do not lie in its ", entry.byte_count));
  {
    const std::lock_guard lock(state.guard);
    if (!state.coverage[found->second].take(byte_offset, byte_offset + bytes.size()))
      throw Error(ErrorCode::internal, concat(state.file->name(), ", array '", array, "': some of the bytes ",
                                              byte_offset, " to ", byte_offset + bytes.size(), " were written twice"));
  }
  try {
    state.file->write(state.start(entry) + byte_offset, bytes);
  } catch (...) {
    state.failed = true;
    throw;
  }
}

void PackedFileWriter::State::check_coverage() const {
  if (failed) throw Error(ErrorCode::internal, concat(file->name(), ": an earlier write failed"));
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (arrays[i].name.front() == '_') continue;
    const std::uint64_t missing = coverage[i].first_missing(arrays[i].byte_count);
    if (missing != arrays[i].byte_count)
      throw Error(ErrorCode::internal,
                  concat(file->name(), ", array '", arrays[i].name, "': byte ", missing, " was never written"));
  }
}

std::vector<std::uint64_t> PackedFileWriter::State::sums(unsigned threads) const {
  const ArrayEntry& table = arrays[arrays.size() - 2];
  std::vector<std::uint64_t> result(table.element_count());
  const envelope::Stretch data{file->descriptor(), header.size(), table.first_byte};
  envelope::sum_blocks(data, threads, [&](std::uint64_t block, std::optional<std::uint64_t> sum) {
    if (!sum) throw Error(ErrorCode::resource, concat(file->name(), ": what was written cannot be read back"));
    result[block] = *sum;
  });
  return result;
}

std::uint64_t PackedFileWriter::commit(unsigned threads) {
  RHORAY_CHECK(state_ != nullptr);  // only once
  State& state = *state_;
  state.check_coverage();
  const std::span<const std::byte> header = std::as_bytes(std::span(state.header));
  state.file->write(0, header);
  const std::vector<std::uint64_t> sums = state.sums(threads);
  const std::span<const std::byte> sum_bytes = std::as_bytes(std::span(sums));
  state.file->write(state.start(state.arrays[state.arrays.size() - 2]), sum_bytes);
  state.file->write(state.start(state.arrays.back()), envelope::make_seal(state.file_bytes, header, sum_bytes));
  state.file->publish();
  const std::uint64_t bytes = state.file_bytes;
  state_.reset();
  return bytes;
}

}  // namespace rhoray::formats
