#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>

namespace rhoray::preprocess {

/// A stream into a file, such as a PendingFile by its open_name(), for code that writes to
/// std::ostream. The first system call that fails sets badbit, and `finish` throws its reason,
/// which std::ofstream loses.
class OutputStream : public std::ostream {
 public:
  /// Truncates the file, or creates it. Refuses a file that cannot be opened.
  /// @param name  for messages; empty: the path
  explicit OutputStream(const std::filesystem::path& path, const std::string& name = {});
  ~OutputStream() override;

  /// Throws when a write has failed. Call it before using a library's own error, which is less
  /// precise.
  void check() const;

  /// Writes the remaining bytes, closes the file, and checks. Nothing may be written afterwards.
  void finish();

 private:
  class Buffer;
  std::unique_ptr<Buffer> buffer_;
};

}  // namespace rhoray::preprocess
