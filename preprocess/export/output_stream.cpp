#include "preprocess/export/output_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <streambuf>
#include <utility>
#include <vector>

#include "formats/base/write_failure.h"

namespace rhoray::preprocess {

/// Bytes from `first_byte_` of the file on that are not yet written. Positions before them may be
/// overwritten later.
class OutputStream::Buffer : public std::streambuf {
 public:
  Buffer(const std::filesystem::path& path, const std::string& name)
      : name_(name.empty() ? path.string() : name),
        descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0) throw write_failure(name_, "open it for writing", errno);
    reset();
  }
  ~Buffer() override {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  void check() const {
    if (error_ != 0) throw write_failure(name_, act_, error_, descriptor_, needed_bytes_);
  }

  void finish() {
    flush();
    check();
    const int closed = ::close(std::exchange(descriptor_, -1));
    if (closed != 0) throw write_failure(name_, "close it", errno);
  }

 protected:
  int_type overflow(int_type letter) override {
    if (!flush()) return traits_type::eof();
    if (!traits_type::eq_int_type(letter, traits_type::eof())) sputc(traits_type::to_char_type(letter));
    return traits_type::not_eof(letter);
  }

  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    const auto size = static_cast<std::size_t>(count);
    if (size > static_cast<std::size_t>(epptr() - pptr()) && !flush()) return 0;
    if (size >= bytes_.size()) {
      if (!write(bytes, size)) return 0;
      reset();
      return count;
    }
    std::memcpy(pptr(), bytes, size);
    pbump(static_cast<int>(size));
    return count;
  }

  int sync() override { return flush() ? 0 : -1; }

  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    if (from == std::ios_base::cur && offset == 0) return position();
    if (!flush()) return pos_type(off_type(-1));
    if (from == std::ios_base::cur) offset += static_cast<off_type>(first_byte_);
    if (from == std::ios_base::end) offset += static_cast<off_type>(end_);
    if (offset < 0) return pos_type(off_type(-1));
    first_byte_ = static_cast<std::uint64_t>(offset);
    return position();
  }

  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }

 private:
  pos_type position() const { return pos_type(static_cast<off_type>(first_byte_) + (pptr() - pbase())); }
  void reset() { setp(bytes_.data(), bytes_.data() + bytes_.size()); }

  bool flush() {
    if (!write(pbase(), static_cast<std::size_t>(pptr() - pbase()))) return false;
    reset();
    return true;
  }

  /// Writes at first_byte_ and advances it. After a failure nothing more is written.
  bool write(const char* bytes, std::size_t count) {
    if (error_ != 0) return false;
    while (count > 0) {
      const ssize_t put = ::pwrite(descriptor_, bytes, count, static_cast<off_t>(first_byte_));
      if (put < 0 && errno == EINTR) continue;
      if (put <= 0) {
        error_ = put < 0 ? errno : ENOSPC;
        act_ = concat("write ", count, " bytes at byte ", first_byte_);
        needed_bytes_ = first_byte_ + count;
        return false;
      }
      bytes += put;
      count -= static_cast<std::size_t>(put);
      first_byte_ += static_cast<std::uint64_t>(put);
      end_ = std::max(end_, first_byte_);
    }
    return true;
  }

  std::string name_;
  int descriptor_;
  std::vector<char> bytes_ = std::vector<char>(std::size_t{256} << 10);
  std::uint64_t first_byte_ = 0;
  std::uint64_t end_ = 0;  ///< of all bytes written
  int error_ = 0;
  std::string act_;
  std::uint64_t needed_bytes_ = 0;
};

OutputStream::OutputStream(const std::filesystem::path& path, const std::string& name)
    : std::ostream(nullptr), buffer_(std::make_unique<Buffer>(path, name)) {
  rdbuf(buffer_.get());
}

OutputStream::~OutputStream() = default;

void OutputStream::check() const {
  buffer_->check();
}

void OutputStream::finish() {
  buffer_->finish();
}

}  // namespace rhoray::preprocess
