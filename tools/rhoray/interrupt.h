#pragma once

#include <filesystem>
#include <stop_token>

namespace rhoray::tools {

/// From now on SIGINT, SIGTERM and SIGHUP end the program with the exit codes 130, 143 and 129, which a shell also
/// shows for programs that these signals kill, and a closed pipe (SIGPIPE) ends it with 141 and without a word. Files
/// that are being written have no name yet and vanish; scratch folders are removed first. Under nohup, SIGHUP stays
/// ignored.
void end_cleanly_on_interrupt();

/// From now on an input that becomes shorter while it is mapped does not kill the program (SIGBUS): zeros are read in
/// the place of lost bytes, and what is computed from them is refused (formats/base/mapped_file.h). Where zeros make
/// the computation crash, or go on for more than a few seconds, the program ends with exit code 4 and one line.
///
/// Faults elsewhere keep their default action. Call it after end_cleanly_on_interrupt.
void survive_lost_bytes();

/// What an error of ErrorCode::interrupted ends the program with: as end_cleanly_on_interrupt says of the signal that
/// has come; 130 where none has.
int interrupted_exit_code();

/// True when a write to a pipe failed because nobody reads it any more.
bool has_lost_its_reader();

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

/// A folder for files that are of no use afterwards, removed with all that is in it; also by an interrupt. Where a
/// program was killed and its folder stays, the next one that makes a folder beside it removes both. There is at most
/// one at a time.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::filesystem::path& inside);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< the open folder, locked for as long as it is of use
};

}  // namespace rhoray::tools
