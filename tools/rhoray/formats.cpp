#include <cstdio>

#include "formats/base/word_list.h"
#include "preprocess/input_file.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/export_formats.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

/// A line of the list.
struct Format {
  std::string name, kind;
  std::vector<std::string> extensions;
  bool is_folder = false;  ///< also a folder of such files
};

std::vector<Format> formats_read() {
  std::vector<Format> formats{{"Packed file", "packed", {".rho"}}};
  for (const preprocess::ForeignFormat& foreign : preprocess::foreign_formats()) {
    Format& format = formats.emplace_back();
    format.name = foreign.name;
    format.kind = preprocess::name_of(foreign.kind);
    for (const std::string_view family : foreign.families)
      if (family.ends_with('/'))
        format.is_folder = true;
      else
        format.extensions.emplace_back(family);
  }
  return formats;
}

std::vector<Format> formats_written() {
  std::vector<Format> formats{{"Packed file", "packed", {".rho"}}};
  for (const ExportFormat& each : export_formats)
    formats.push_back({each.name,
                       each.for_grids && each.for_tets ? "volume or mesh"
                       : each.for_grids                ? "volume"
                                                       : "mesh",
                       {each.extension}});
  formats.push_back({"Pictures", "picture", picture_extensions()});
  return formats;
}

void print(const char* heading, const std::vector<Format>& formats) {
  std::printf("%s:\n", heading);
  for (const Format& format : formats)
    std::printf("  %-15s %-31s %s%s\n", format.kind.c_str(), format.name.c_str(),
                joined(format.extensions, " ").c_str(), format.is_folder ? ", folders" : "");
}

Json list_of(const std::vector<Format>& formats) {
  Json json = Json::array();
  for (const Format& format : formats)
    json.push_back({{"format", format.name},
                    {"kind", format.kind},
                    {"extensions", format.extensions},
                    {"folders", format.is_folder}});
  return json;
}

int run(bool json) {
  if (json) {
    std::puts(dump(Json{{"read", list_of(formats_read())}, {"written", list_of(formats_written())}}).c_str());
    return 0;
  }
  print("Read", formats_read());
  print("Written", formats_written());
  return 0;
}

}  // namespace

Subcommand formats_subcommand() {
  const auto json = std::make_shared<bool>(false);
  return {.name = "formats",
          .summary = "List the formats that are read and written",
          .group = "Files",
          .examples = {"rhoray formats", "rhoray formats --json"},
          .options = {with_details(flag_option("--json", "Print one JSON document to stdout", *json),
                                   "Samples without a header are read with `rhoray pack --raw`")},
          .run = [json] { return run(*json); }};
}

}  // namespace rhoray::tools
