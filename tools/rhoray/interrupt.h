#pragma once

#include <filesystem>
#include <stop_token>

namespace rhoray::tools {

/// From now on an interrupt (SIGINT) ends the program with exit code 130. Files that are being written have no name yet
/// and vanish; scratch folders are removed first.
void end_cleanly_on_interrupt();

/// While it lives, an interrupt asks for an end instead of ending the program, for work that has something to show of
/// what it has done; a second one ends it. There is at most one at a time.
class InterruptRequest {
 public:
  InterruptRequest();
  InterruptRequest(const InterruptRequest&) = delete;
  InterruptRequest& operator=(const InterruptRequest&) = delete;
  ~InterruptRequest();

  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
};

/// A folder for files that are of no use afterwards, removed with all that is in it; also by an interrupt.
/// There is at most one at a time.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::filesystem::path& inside);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace rhoray::tools
