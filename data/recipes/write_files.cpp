#include "data/recipes/write_files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "formats/base/trouble.h"

namespace rhoray::recipes {

NewFile::NewFile(std::filesystem::path path, bool replace_existing) : path_(std::move(path)) {
  if (!replace_existing && std::filesystem::exists(path_))
    throw Error(Trouble::usage, concat(path_.string(), ": exists already"), "add --force to replace it");
  unfinished_ = path_;
  unfinished_ += concat(".unfinished-", getpid());
  descriptor_ = open(unfinished_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  check(descriptor_ >= 0, "created");
}

NewFile::~NewFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(unfinished_.c_str());
}

void NewFile::check(bool worked, std::string_view doing) const {
  if (!worked)
    throw Error(Trouble::resource, concat(path_.string(), ": cannot be ", doing, ": ", std::strerror(errno)));
}

void NewFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    check(written > 0, "written");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void NewFile::commit() {
  check(fsync(descriptor_) == 0, "written");
  check(rename(unfinished_.c_str(), path_.c_str()) == 0, "named");
  close(descriptor_);
  descriptor_ = -1;
}

void write_nrrd(const std::filesystem::path& path, bool replace_existing, const NrrdHeader& header,
                const std::function<void(NewFile& raw)>& write_samples) {
  if (path.extension() != ".nhdr")
    throw Error(Trouble::usage, concat(path.string(), ": the name of the header must end in .nhdr"));
  const std::filesystem::path raw_path = std::filesystem::path(path).replace_extension(".raw");
  const auto triple = [](const Vec3& v) { return concat("(", v.x, ",", v.y, ",", v.z, ")"); };
  const Index3 n = header.sample_count;

  const bool is_colored = header.component_count > 1;
  NewFile text(path, replace_existing), raw(raw_path, replace_existing);
  text.write(concat(
      "NRRD0005\ncontent: ", header.content, "\ntype: ", header.type, "\ndimension: ", is_colored ? "4\n" : "3\n",
      header.in_patient_mm ? "space: left-posterior-superior\n" : "space dimension: 3\n",               //
      "sizes: ", is_colored ? concat(header.component_count, " ") : "", n.x, " ", n.y, " ", n.z, "\n",  //
      "space directions: ", is_colored ? "none " : "", triple({header.spacing.x, 0, 0}), " ",
      triple({0, header.spacing.y, 0}), " ", triple({0, 0, header.spacing.z}), "\n",
      header.in_patient_mm ? "space units: \"mm\" \"mm\" \"mm\"\n" : "",                                   //
      "kinds: ", is_colored ? "RGB-color " : "", "domain domain domain\nendian: little\nencoding: raw\n",  //
      "space origin: ", triple(header.first_sample), "\n",                                                 //
      "data file: ", raw_path.filename().string(), "\n"));
  write_samples(raw);
  raw.commit();
  text.commit();
}

}  // namespace rhoray::recipes
