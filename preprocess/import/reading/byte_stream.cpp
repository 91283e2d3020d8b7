#include "preprocess/import/reading/byte_stream.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <new>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct ByteStream::Inflater {
  z_stream stream{};
  bool finished = false;

  /// gzip files may be put together from several streams (RFC 1952).
  bool another_follows() const {
    return stream.avail_in >= 2 && stream.next_in[0] == 0x1f && stream.next_in[1] == 0x8b;
  }
};

namespace {

constexpr std::size_t largest_piece = std::size_t{1} << 30;  // zlib counts in 32 bits

/// True for the first two bytes of gzip (RFC 1952) and zlib (RFC 1950) data.
bool begins_as_packed(std::span<const std::byte> source) {
  if (source.size() < 2) return false;
  const auto first = std::to_integer<unsigned>(source[0]), second = std::to_integer<unsigned>(source[1]);
  const bool gzip = first == 0x1f && second == 0x8b;
  const bool zlib = (first & 0x0f) == 8 && (first >> 4) <= 7 && (first * 256 + second) % 31 == 0;
  return gzip || zlib;
}

}  // namespace

ByteStream::ByteStream(const std::filesystem::path& path, std::span<const std::byte> source, bool may_be_packed)
    : path_(path), rest_(source), source_bytes_(source.size()) {
  if (!may_be_packed || !begins_as_packed(source)) return;
  auto inflater = std::make_unique<Inflater>();
  // +32: detect gzip or zlib by the header
  if (::inflateInit2(&inflater->stream, 15 + 32) != Z_OK) throw std::bad_alloc();
  inflater_ = std::move(inflater);
}

ByteStream::~ByteStream() {
  if (inflater_) ::inflateEnd(&inflater_->stream);
}

std::uint64_t ByteStream::read_packed(std::span<std::byte> bytes) {
  z_stream& stream = inflater_->stream;
  std::uint64_t filled = 0;
  while (filled < bytes.size() && !inflater_->finished) {
    if (stream.avail_in == 0) {
      const std::size_t piece = std::min(rest_.size(), largest_piece);
      // zlib only reads it
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(rest_.data()));
      stream.avail_in = static_cast<uInt>(piece);
      rest_ = rest_.subspan(piece);
    }
    const std::size_t room = std::min<std::size_t>(bytes.size() - filled, largest_piece);
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + filled);
    stream.avail_out = static_cast<uInt>(room);
    const int outcome = ::inflate(&stream, Z_NO_FLUSH);
    filled += room - stream.avail_out;
    if (outcome == Z_STREAM_END && inflater_->another_follows() && ::inflateReset(&stream) == Z_OK) continue;
    inflater_->finished = outcome == Z_STREAM_END;
    if (outcome == Z_BUF_ERROR && rest_.empty() && stream.avail_in == 0)
      refuse_input(path_, concat("packed byte ", source_bytes_), "the end of the data", "more of the packed stream");
    if (outcome != Z_OK && outcome != Z_STREAM_END && outcome != Z_BUF_ERROR)
      refuse_input(path_, concat("packed byte ", source_bytes_ - rest_.size() - stream.avail_in), "damaged data",
                   "a whole zlib stream");
  }
  return filled;
}

std::uint64_t ByteStream::read_some(std::span<std::byte> bytes) {
  if (inflater_) return read_packed(bytes);
  const std::size_t count = std::min(bytes.size(), rest_.size());
  if (count > 0) std::memcpy(bytes.data(), rest_.data(), count);
  rest_ = rest_.subspan(count);
  return count;
}

void ByteStream::read(std::span<std::byte> bytes, std::string_view what) {
  const std::uint64_t count = read_some(bytes);
  if (count != bytes.size())
    refuse_input(path_, what, concat("the end of the data after ", count, " bytes"), concat(bytes.size(), " bytes"));
}

std::uint64_t ByteStream::drain(std::uint64_t most) {
  if (!inflater_) {
    const std::uint64_t count = std::min<std::uint64_t>(most, rest_.size());
    rest_ = rest_.subspan(count);
    return count;
  }
  std::array<std::byte, 4096> waste;
  std::uint64_t total = 0;
  while (total < most) {
    const std::uint64_t count = read_some(std::span(waste).first(std::min<std::uint64_t>(waste.size(), most - total)));
    if (count == 0) break;
    total += count;
  }
  return total;
}

std::uint64_t ByteStream::finish() {
  return drain(std::numeric_limits<std::uint64_t>::max());
}

ForeignFile unpacked_file(const std::filesystem::path& path) {
  const ForeignFile file(path);
  if (!extension_of(path).ends_with(".gz")) return file;
  ByteStream measured(path, file.bytes(), true);
  if (!measured.is_packed()) refuse_input(path, "byte 0", "another beginning", "a gzip file, as its name says");
  const auto content = std::make_shared<Array<std::byte>>(measured.finish());
  ByteStream(path, file.bytes(), true).read(*content, "content");
  return {path, std::shared_ptr<const void>(content, content->data()), content->size()};
}

}  // namespace rhoray::preprocess
