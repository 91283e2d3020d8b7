#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

namespace rhoray::tools {

// How a program begins and ends: standard streams, signals, inputs that become shorter.

/// Gives the descriptors 0 to 2 to nobody else: where one of them is closed, the next file that is
/// opened would get it, and messages would go into that file. Writing to an output that was closed
/// still fails. To be called first in main.
void keep_standard_descriptors();

/// From now on SIGINT, SIGTERM and SIGHUP end the program with exit codes 130, 143 and 129, as a
/// shell reports for programs killed by these signals. A closed pipe (SIGPIPE) ends it with 141 and
/// no message. Files being written have no name yet and vanish; scratch folders are removed first.
/// Under nohup, SIGHUP stays ignored.
void end_cleanly_on_interrupt();

/// From now on an input that becomes shorter while it is mapped does not kill the program (SIGBUS).
/// Zeros are read in place of the lost bytes, and results computed from them are refused
/// (formats/base/mapped_file.h). If the zeros make the computation crash or run for more than a few
/// seconds, the program ends with exit code 4 and one line.
///
/// Faults elsewhere keep their default action. Call it after end_cleanly_on_interrupt.
void survive_lost_bytes();

/// The exit code for ErrorCode::interrupted: the code of the signal received, see
/// end_cleanly_on_interrupt; 130 if there was none.
int interrupted_exit_code();

/// Writes what is left for standard output. Where not all of it could be written, says so on stderr
/// and returns ErrorCode::resource in the place of success; where its reader has gone, returns 141
/// and says nothing.
/// @param exit_code  what the program would end with
int finish_standard_output(int exit_code);

/// While this object exists, an interrupt requests a stop instead of ending the program: partial
/// results can be written, and clients told. A second interrupt ends the program. At most one object
/// at a time.
class InterruptRequest {
 public:
  /// @param notice  is printed to stderr when an interrupt comes; empty where that is the usual end
  explicit InterruptRequest(std::string notice);
  InterruptRequest(const InterruptRequest&) = delete;
  InterruptRequest& operator=(const InterruptRequest&) = delete;
  ~InterruptRequest();

  std::stop_token token() const { return source_.get_token(); }
  bool request_end();  ///< as an interrupt does; false if it was requested before

 private:
  std::stop_source source_;
  std::string notice_;
};

/// A folder for temporary files, removed with its content at the end and on an interrupt. If a
/// program was killed and its folder remains, the next program that makes a folder beside it
/// removes it. At most one at a time.
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
