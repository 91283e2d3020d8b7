#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

NeutralVolume read_raw(const std::filesystem::path& path, const RawVolume& raw) {
  const ForeignFile file(path);
  const std::uint64_t wanted = checked_volume_bytes(path, raw.sample_count, raw.type);
  const std::uint64_t size = file.bytes().size();
  const auto samples = samples_behind(path, file.bytes(), raw.skipped_bytes, wanted);
  NeutralVolume volume;
  volume.sample_count = raw.sample_count;
  volume.type = raw.type;
  volume.field_name = stem_of(path);
  if (is_native(raw.type, raw.big_endian)) {
    leave_samples_in(volume, file, samples);
  } else {
    set_samples(volume, {samples.begin(), samples.end()});
    make_native(volume.owned_samples, formats::element_bytes(raw.type), raw.big_endian);
  }
  if (const std::uint64_t rest = size - raw.skipped_bytes - wanted; rest > 0)
    volume.notes.push_back(concat(rest, " bytes after the samples were left out"));
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
