#include "preprocess/process/foreign_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>

#include "formats/base/descriptor.h"
#include "formats/base/lower_case.h"
#include "formats/base/mapped_file.h"
#include "formats/base/regular_file.h"
#include "formats/format_error.h"

namespace rhoray::preprocess {

namespace {

std::mutex noting;
std::map<std::filesystem::path, SourceFile>& notes() {
  static std::map<std::filesystem::path, SourceFile> all;
  return all;
}

}  // namespace

void note_source(const std::filesystem::path& path) {
  const SourceFile source = source_file(path);
  const std::lock_guard lock(noting);
  notes().try_emplace(source.path, source);
}

bool is_there(const std::filesystem::path& path) {
  note_source(path);
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

std::vector<SourceFile> noted_sources() {
  const std::lock_guard lock(noting);
  std::vector<SourceFile> sources;
  for (const auto& [path, source] : notes()) sources.push_back(source);
  return sources;
}

ForeignFile::ForeignFile(const std::filesystem::path& path) : path_(path) {
  note_source(path);
  const Descriptor file(open_regular_file(path));
  struct stat facts {};
  if (::fstat(file.number(), &facts) != 0)
    throw Error(ErrorCode::unreadable, concat(path.string(), ": ", std::strerror(errno)));
  if (facts.st_size == 0) refuse_input(path, "byte 0", "an empty file", "a header");
  size_ = static_cast<std::size_t>(facts.st_size);
  const auto mapped = std::make_shared<const MappedFile>(file.number(), size_, path.string());
  start_ = std::shared_ptr<const void>(mapped, mapped->bytes().data());
}

ForeignFile::ForeignFile(const std::filesystem::path& path, std::shared_ptr<const void> start, std::size_t size)
    : path_(path), start_(std::move(start)), size_(size) {
  if (size == 0) refuse_input(path, "byte 0", "an empty file", "a header");
}

void refuse_input(const std::filesystem::path& path, std::string_view place, std::string_view found,
                  std::string_view expected, ErrorCode error_code) {
  formats::refuse(path.string(), place, found, expected, error_code);
}

std::string extension_of(const std::filesystem::path& path) {
  const std::filesystem::path whole(lower_case(path.filename().string()));
  const std::string last = whole.extension().string();
  return last == ".gz" ? whole.stem().extension().string() + last : last;
}

std::string stem_of(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name.substr(0, name.size() - extension_of(path).size());
}

}  // namespace rhoray::preprocess
