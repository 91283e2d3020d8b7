#include "preprocess/process/counts.h"

namespace rhoray::preprocess {

void hand_over_counts(const std::vector<std::uint64_t>& counts, int descriptor) {
  formats::FileDescription description;
  description.kind = "counts";
  formats::PackedFileWriter writer(descriptor, description,
                                   {{.name = "counts", .type = formats::ElementType::U64, .shape = {counts.size()}}});
  writer.write_all("counts", std::span<const std::uint64_t>(counts));
  writer.commit();
}

std::vector<std::uint64_t> take_counts(const formats::PackedFile& file, std::size_t expected) {
  const std::span<const std::uint64_t> counts = file.array<std::uint64_t>("counts", {expected});
  return {counts.begin(), counts.end()};
}

}  // namespace rhoray::preprocess
