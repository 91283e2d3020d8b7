#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>

namespace rhoray::preprocess {

/// A stream into a file, such as a PendingFile by its open_name(), for what writes to std::ostream.
/// The first call of the system that fails sets badbit, and `finish` throws its reason, which std::ofstream forgets.
class OutputStream : public std::ostream {
 public:
  /// Empties the file, or makes one. Refuses a file that cannot be opened.
  /// @param name  for messages; empty: the path
  explicit OutputStream(const std::filesystem::path& path, const std::string& name = {});
  ~OutputStream() override;

  /// Throws when a write has failed. To be asked before what a library says, which knows less.
  void check() const;

  /// Writes what is left, closes the file, and checks. Nothing may be written afterwards.
  void finish();

 private:
  class Buffer;
  std::unique_ptr<Buffer> buffer_;
};

}  // namespace rhoray::preprocess
