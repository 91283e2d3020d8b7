#include "tests/faults/crash_model.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

namespace fs = std::filesystem;

std::vector<RecordedCall> read_calls(const fs::path& record) {
  const std::string all = read_file(record);
  std::size_t at = 0;
  const auto take = [&](std::uint64_t count) {
    if (count > all.size() - at) throw std::runtime_error("the record ends within a call");
    return all.substr(std::exchange(at, at + count), count);
  };
  std::vector<RecordedCall> calls;
  while (at < all.size()) {
    RecordedCall call;
    std::memcpy(&call.header, take(sizeof call.header).data(), sizeof call.header);
    call.name = take(call.header.name_bytes);
    call.second_name = take(call.header.second_name_bytes);
    call.bytes = take(call.header.byte_count);
    call.record_end = at;
    calls.push_back(std::move(call));
  }
  return calls;
}

NumberedFolder read_folder(const fs::path& folder) {
  NumberedFolder files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    struct stat status {};
    if (::lstat(entry.path().c_str(), &status) != 0 || !S_ISREG(status.st_mode))
      throw std::runtime_error(entry.path().string() + " is no file");
    files[entry.path().filename()] = {status.st_ino, read_file(entry.path())};
  }
  return files;
}

/// Turns recorded calls into changes.
class CrashModel::Reader {
 public:
  Reader(CrashModel& model, const NumberedFolder& before) : model_(model) {
    for (const auto& [name, file] : before) model_.names_[name] = now_[name] = add_file(file.number, file.content);
  }

  void read(std::size_t index, const RecordedCall& call) {
    const CallHeader& header = call.header;
    Change change{.call = index, .record_end = call.record_end};
    switch (header.kind) {
      case CallKind::create:
        if (const std::size_t file = add_file(header.file, {}); !call.name.empty())
          set_names(std::move(change), {{call.name, file}});
        break;
      case CallKind::write:
        write(std::move(change), header, call.bytes);
        break;
      case CallKind::resize:
        change.file = file_of(header);
        set_size(std::move(change), header.at);
        break;
      case CallKind::map:
        throw std::runtime_error("a file is written through memory: which pages change is not recorded");
      case CallKind::link:
        set_names(std::move(change), {{call.name, file_of(header)}});
        break;
      case CallKind::rename:
        set_names(std::move(change), {{call.name, std::nullopt}, {call.second_name, now_.at(call.name)}});
        break;
      case CallKind::exchange:
        set_names(std::move(change), {{call.name, now_.at(call.second_name)}, {call.second_name, now_.at(call.name)}});
        break;
      case CallKind::unlink:
        set_names(std::move(change), {{call.name, std::nullopt}});
        break;
      case CallKind::flush_file:
        promise(index, header.at, file_of(header));
        break;
      case CallKind::flush_folder:
        promise(index, header.at, std::nullopt);
        break;
    }
  }

 private:
  std::size_t add_file(std::uint64_t number, const std::string& content) {
    model_.files_.push_back(content);
    sizes_.push_back(content.size());
    // Inode numbers are used again when files are gone.
    return numbers_[number] = model_.files_.size() - 1;
  }

  std::size_t file_of(const CallHeader& header) const {
    const auto found = numbers_.find(header.file);
    if (found == numbers_.end()) throw std::runtime_error("a file was made by a call that is not recorded");
    return found->second;
  }

  void write(Change change, const CallHeader& header, std::string_view bytes) {
    constexpr std::uint64_t page_bytes = 4096;
    change.file = file_of(header);
    for (std::uint64_t at = header.at; !bytes.empty();) {
      const std::string_view piece = bytes.substr(0, page_bytes - at % page_bytes);
      change.at = at;
      change.bytes = piece;
      model_.changes_.push_back(change);
      at += piece.size();
      bytes.remove_prefix(piece.size());
    }
    change.bytes.clear();
    const std::uint64_t end = header.at + header.byte_count;
    if (end > sizes_[change.file]) set_size(std::move(change), end);
  }

  void set_size(Change change, std::uint64_t size) {
    change.what = Change::What::size;
    change.at = sizes_[change.file] = size;
    model_.changes_.push_back(std::move(change));
  }

  void set_names(Change change, decltype(Change::names) names) {
    change.what = Change::What::names;
    for (const auto& [name, file] : names) {
      if (file)
        now_[name] = *file;
      else
        now_.erase(name);
    }
    change.names = std::move(names);
    model_.changes_.push_back(std::move(change));
  }

  /// Marks the changes that a flush makes durable, of a file or of the names. The flush began when
  /// the record had record_bytes bytes.
  void promise(std::size_t flush, std::uint64_t record_bytes, std::optional<std::size_t> file) {
    for (Change& change : model_.changes_) {
      const bool is_of_names = change.what == Change::What::names;
      const bool is_flushed = file ? !is_of_names && change.file == *file : is_of_names;
      if (is_flushed && change.record_end <= record_bytes) change.flush = std::min(change.flush, flush);
    }
  }

  CrashModel& model_;
  std::map<std::uint64_t, std::size_t> numbers_;  ///< inode number -> file
  std::map<std::string, std::size_t> now_;        ///< names after the calls so far
  std::vector<std::uint64_t> sizes_;              ///< sizes of the files after the calls so far
};

CrashModel::CrashModel(const NumberedFolder& before, const std::vector<RecordedCall>& calls) {
  Reader reader(*this, before);
  for (std::size_t i = 0; i < calls.size(); ++i) reader.read(i, calls[i]);
}

/// The folder with those changes for which is_there(change) is true.
template <class IsThere>
FolderContents CrashModel::state(const IsThere& is_there) const {
  struct File {
    std::string bytes;
    std::uint64_t size;
  };
  std::vector<File> files;
  for (const std::string& content : files_) files.push_back({content, content.size()});
  std::map<std::string, std::size_t> names = names_;
  for (const Change& change : changes_) {
    if (!is_there(change)) continue;
    if (change.what == Change::What::names) {
      for (const auto& [name, file] : change.names) {
        if (file)
          names[name] = *file;
        else
          names.erase(name);
      }
      continue;
    }
    File& file = files[change.file];
    if (change.what == Change::What::size) {
      file.size = change.at;
      // What is cut off is gone.
      file.bytes.resize(std::min<std::size_t>(file.bytes.size(), change.at));
      continue;
    }
    const std::size_t end = change.at + change.bytes.size();
    if (file.bytes.size() < end) file.bytes.resize(end);
    file.bytes.replace(change.at, change.bytes.size(), change.bytes);
  }
  FolderContents contents;
  for (const auto& [name, file] : names) {
    contents[name] = files[file].bytes;
    contents[name].resize(files[file].size);
  }
  return contents;
}

FolderContents CrashModel::outcome() const {
  return state([](const Change&) { return true; });
}

FolderContents CrashModel::draw(std::size_t calls_ended, std::mt19937_64& random) const {
  // For data and for names separately: in every fourth state, all changes are there, or none.
  const auto draw_share = [&] {
    const int choice = std::uniform_int_distribution(0, 7)(random);
    return choice < 2 ? choice : std::uniform_real_distribution(0.0, 1.0)(random);
  };
  const double share_of_data = draw_share(), share_of_names = draw_share();
  const bool has_journal = std::bernoulli_distribution(0.5)(random);
  bool journal_goes_on = true;
  return state([&](const Change& change) {
    if (change.call >= calls_ended) return false;
    const bool is_of_names = change.what == Change::What::names;
    const bool is_promised = change.flush < calls_ended;
    const bool is_there =
        is_promised || std::bernoulli_distribution(is_of_names ? share_of_names : share_of_data)(random);
    if (!is_of_names || !has_journal) return is_there;
    return journal_goes_on = journal_goes_on && is_there;
  });
}

}  // namespace rhoray::tests
