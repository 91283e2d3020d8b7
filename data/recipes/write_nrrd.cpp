#include "data/recipes/write_nrrd.h"

#include <memory>
#include <vector>

#include "formats/base/error.h"

namespace rhoray::recipes {

void write_nrrd(const std::filesystem::path& path, bool replace_existing, const NrrdHeader& header,
                const std::function<void(PendingFile& raw)>& write_samples) {
  if (path.extension() != ".nhdr")
    throw Error(ErrorCode::usage, concat(path.string(), ": the name of the header must end in .nhdr"));
  const std::filesystem::path raw_path = std::filesystem::path(path).replace_extension(".raw");
  const auto triple = [](const Vec3& v) { return concat("(", v.x, ",", v.y, ",", v.z, ")"); };
  const Index3 n = header.sample_count;

  const bool is_colored = header.component_count > 1;
  std::vector<std::unique_ptr<PendingFile>> files;
  for (const std::filesystem::path& name : {raw_path, path})
    files.push_back(std::make_unique<PendingFile>(name, PendingFile::Options{.replace_existing = replace_existing}));
  PendingFile &raw = *files[0], &text = *files[1];
  text.append(concat(
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
  publish_all(files);
}

}  // namespace rhoray::recipes
