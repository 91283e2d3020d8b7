#include "preprocess/source_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <system_error>

#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray::preprocess {

SourceFile source_file(const std::filesystem::path& path) {
  std::error_code failed;
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, failed);
  SourceFile source{.path = failed ? std::filesystem::absolute(path) : canonical};
  struct stat facts {};
  if (::stat(source.path.c_str(), &facts) != 0) return source;
  source.exists = true;
  source.device = facts.st_dev;
  source.inode = facts.st_ino;
  source.bytes = static_cast<std::uint64_t>(facts.st_size);
  source.changed_ns = facts.st_ctim.tv_sec * std::int64_t{1'000'000'000} + facts.st_ctim.tv_nsec;
  return source;
}

bool was_read(const std::filesystem::path& path, const std::vector<SourceFile>& sources) {
  const SourceFile file = source_file(path);
  return file.exists && std::any_of(sources.begin(), sources.end(), [&](const SourceFile& source) {
           return source.exists && source.device == file.device && source.inode == file.inode;
         });
}

void require_not_read(const std::filesystem::path& output, const std::vector<SourceFile>& sources) {
  if (was_read(output, sources))
    throw Error(ErrorCode::usage, concat(output.string(), ": is a file of the input; expected another name"));
}

}  // namespace rhoray::preprocess
