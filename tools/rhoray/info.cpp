#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/printable.h"
#include "formats/base/word_list.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/intact.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/input_file.h"
#include "preprocess/open_data.h"
#include "preprocess/unpack_mesh.h"
#include "tools/rhoray/cli/command_line.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/info/foreign.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct InfoOptions {
  CommonOptions common;
  std::vector<std::filesystem::path> files;
  render::ReadSpec read;
  bool findings = false;
};

/// Bytes of a packed mesh without points, field values, boundary and envelope.
std::uint64_t structure_bytes(const formats::PackedFile& file) {
  std::uint64_t bytes = 0;
  for (const formats::ArrayEntry& entry : file.arrays())
    if (entry.name != "points" && entry.name != "boundary" && !entry.name.starts_with("field.") &&
        !entry.name.starts_with("cell_field.") && !entry.name.starts_with('_'))
      bytes += entry.byte_count;
  return bytes;
}

/// A packed file as JSON: its description, its arrays, and the memory needed to read it completely.
Json packed_info(const std::filesystem::path& path, bool with_findings) {
  const formats::PackedFile file = formats::PackedFile::open(path);
  const std::string& kind = file.description().kind;
  Json json{{"file", path.string()},
            {"kind", kind},
            {"packed", true},
            {"format_version", file.version()},
            {"file_bytes", file.file_bytes()}};
  if (kind == "grid")
    json.update(json_of(formats::BrickGrid(file).description()));
  else if (kind == "tets") {
    const formats::TetMesh mesh(file);
    json.update(json_of(mesh.description()));
    Box3 box;
    for (const auto& point : mesh.points())
      box.extendBy(mesh.description().origin + Vec3(point[0], point[1], point[2]));
    json["box"] = json_of(box);
    json["structure_bytes"] = structure_bytes(file);
    if (with_findings) {
      refuse_damage(file, 0);
      json["findings"] = findings_json(preprocess::inspect_mesh(preprocess::unpack_mesh(mesh)));
    }
  } else if (kind == formats::ColorGrid::kind)
    json.update(json_of(formats::ColorGrid(file).description()));
  else if (kind == formats::TriangleMesh::kind)
    json.update(json_of(formats::TriangleMesh(file).description()));
  json["memory"] = {{"mapped_bytes", file.file_bytes()}};
  json["arrays"] = Json::array();
  for (const formats::ArrayEntry& entry : file.arrays())
    json["arrays"].push_back({{"name", entry.name},
                              {"type", formats::element_name(entry.type)},
                              {"shape", entry.shape},
                              {"first_byte", entry.first_byte},
                              {"byte_count", entry.byte_count}});
  formats::require_intact(file);
  return json;
}

std::string row(const std::string& name, const std::string& text) {
  return concat("  ", name, std::string(name.size() < 12 ? 12 - name.size() : 1, ' '), text, "\n");
}

std::string word(const Json& json) {
  return json.get<std::string>();
}

/// @param extent  of which the numbers are told to within 1/10,000; 0: not known
std::string numbers(const Json& list, const char* separator = " ", double extent = 0) {
  std::string text;
  for (const Json& number : list) {
    if (!text.empty()) text += separator;
    text += number.is_number_float() ? rounded_within(extent, number.get<double>(), 6) : number.dump();
  }
  return text;
}

double extent_of(const Json& range) {
  return range[1].get<double>() - range[0].get<double>();
}

std::string with_unit(const std::string& text, const Json& unit) {
  return word(unit).empty() ? text : concat(text, " ", word(unit));
}

std::string certificate_text(const Json& certificate, const Json& unit) {
  std::string text;
  if (const Json& coverage = certificate["coverage"]; coverage.is_number())
    text += row("", concat("covers ", rounded(100 * coverage.get<double>(), 6), " % of the source's volume"));
  text += row("", concat("certified at ", grouped(certificate["point_count"]), " points: error at most ",
                         with_unit(rounded(certificate["max_error"]), unit), " at (", numbers(certificate["max_at"]),
                         "), rms ", with_unit(rounded(certificate["rms_error"]), unit)));
  if (const Json& requested = certificate["requested_error"]; requested.is_number())
    text += row("", concat("requested error: at most ", with_unit(rounded(requested), unit), ", ",
                           certificate["meets_request"] ? "reached" : "not reached"));
  return text;
}

/// `1 'liver', 2 'spleen'`
std::string label_names_text(const Json& names) {
  constexpr std::size_t most_shown = 32;
  std::vector<std::string> texts;
  for (const auto& [label, name] : names.items())
    if (texts.size() < most_shown) texts.push_back(concat(label, " '", word(name), "'"));
  if (names.size() > most_shown) texts.push_back(concat(names.size() - most_shown, " more (--json lists all)"));
  return joined(texts);
}

/// @param label  "field", or "cells" for one value per cell
std::string field_text(const Json& field, const std::string& label) {
  std::string title = concat("'", word(field["name"]), "'  ", word(field["type"]));
  if (field.contains("components") && field["components"] != 1) title += concat(" x ", field["components"].get<int>());
  if (field["range"].is_null()) return row(label, title + "  no finite value");
  const double extent = extent_of(field["range"]);
  title += "  " + with_unit(numbers(field["range"], " to ", extent), field["unit"]);
  if (const auto count = field["no_data_count"].get<std::uint64_t>(); count != 0)
    title += concat(", ", counted(count, "value without data", "values without data"));
  std::string text = row(label, title);
  formats::FieldSummary summary;
  summary.histogram = field["histogram"].get<std::vector<std::uint64_t>>();
  summary.range = {field["range"][0], field["range"][1]};
  text += row("", "|" + histogram_bars(summary) + "|");
  const bool is_whole = word(field["type"]).front() != 'F';
  const auto percentile = [&](const char* percent) {
    const double value = field["percentiles"][percent].get<double>();
    return rounded_within(extent, is_whole ? std::floor(value) : value);
  };
  text += row("", concat("percentiles p1 ", percentile("1"), ", p50 ", percentile("50"), ", p99 ", percentile("99"),
                         field["otsu_threshold"].is_null()
                             ? std::string{}
                             : concat("; Otsu's threshold ", rounded_within(extent, field["otsu_threshold"])),
                         "; each to within ", rounded(formats::percentile_error(summary), 2)));
  if (field.contains("label_names")) text += row("", concat("labels ", label_names_text(field["label_names"])));
  if (field.contains("automatic_isovalue")) {
    const Json& isovalue = field["automatic_isovalue"];
    const Json& valleys = isovalue["other_valleys"];
    text += row("", concat("isovalue auto ", rounded_within(extent, isovalue["value"]), " (", word(isovalue["from"]),
                           ")", valleys.empty() ? "" : concat("; other valleys: ", numbers(valleys, ", ", extent))));
  }
  if (field.contains("certificate")) text += certificate_text(field["certificate"], field["unit"]);
  return text;
}

/// `0.5 x 1 x 2`; where the spacing varies along an axis, `0.5 x 1 x 0.1 to 3`.
std::string spacing_text(const Json& geometry) {
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Json& range = geometry["spacing_range"][axis];
    const bool varies = range.is_array() && range[0] != range[1];
    text += concat(axis == 0 ? "" : " x ",
                   varies ? numbers(range, " to ") : numbers(Json::array({geometry["spacing"][axis]})));
  }
  return text;
}

std::string geometry_text(const Json& json) {
  std::string text;
  if (json.contains("geometry")) {
    const Json& geometry = json["geometry"];
    text += row("spacing", with_unit(spacing_text(geometry), json["length_unit"]));
    text += row("origin", numbers(geometry["origin"]));
    std::string axes;
    for (const Json& axis : geometry["direction"]) axes += concat(axes.empty() ? "(" : "  (", numbers(axis), ")");
    text += row("direction", axes);
    if (json.contains("space") && !word(json["space"]).empty())
      text += row("space", word(json["space"]) == "RAS" ? "RAS: x to the patient's right, y to the front, z to the head"
                                                        : "LPS: x to the patient's left, y to the back, z to the head");
  }
  if (json.contains("box")) {
    const Json &low = json["box"]["low"], &high = json["box"]["high"];
    double extent = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) extent = std::max(extent, extent_of({low[axis], high[axis]}));
    text += row("box", with_unit(concat("(", numbers(low, " ", extent), ") to (", numbers(high, " ", extent), ")"),
                                 json["length_unit"]));
  }
  return text;
}

/// How the file stores the data, and the memory that it takes.
std::string layout_text(const Json& json) {
  std::string text;
  if (json.contains("layout")) {
    const Json& layout = json["layout"];
    if (layout["sparse"].get<bool>())
      text += row("layout", concat(grouped(layout["stored_bricks"]), " of ", grouped(layout["bricks"]), " bricks of ",
                                   layout["brick_edge"].get<int>(), "^3 samples"));
    else
      text += row("layout", layout["linear"].get<bool>()
                                ? std::string("linear")
                                : concat("bricks of ", layout["brick_edge"].get<int>(), "^3 samples, superbricks of ",
                                         numbers(layout["superbrick_edge"], " x "), " bricks"));
  }
  if (json.contains("clusters")) {
    const Json& clusters = json["clusters"];
    const auto count = clusters["count"].get<std::uint64_t>(), size = clusters["size"].get<std::uint64_t>();
    const double vertices = clusters["vertices"].get<double>() / static_cast<double>(count);
    text += row("clusters", concat(grouped(count), " of ", size, size == 1 ? " cell, " : " cells, ",
                                   rounded(vertices, 3), " vertices each"));
  }
  if (json.contains("leaf_cells"))
    text += row("leaf cells", concat(numbers(json["leaf_cells"]["count"], " x "), ", ",
                                     grouped(json["leaf_cells"]["items"]), " entries in their lists"));
  if (json.contains("macro_levels"))
    text += row("levels", concat(json["macro_levels"]["count"].get<int>(), " of macrocells, factor ",
                                 json["macro_levels"]["factor"].get<std::int64_t>()));
  if (json.contains("structure_bytes")) {
    const double per_cell = json["structure_bytes"].get<double>() / json["cells"].get<double>();
    text += row("structure", concat(rounded(per_cell, 3), " bytes per cell, without points, fields and boundary"));
  }
  if (json.contains("memory"))
    for (const auto& [name, bytes] : json["memory"].items())
      text += row("memory", concat(name.substr(0, name.rfind('_')), " ", bytes_text(bytes)));
  return text;
}

/// One line about a grid of an OpenVDB file.
std::string grid_text(const Json& grid) {
  std::string text = concat("'", word(grid["name"]), "'  ", word(grid["value_type"]), ", ", word(grid["class"]), ", ",
                            grouped(grid["active_voxels"]), " active voxels");
  const auto corner = [](const Json& index) {
    return concat("(", index[0].get<std::int64_t>(), " ", index[1].get<std::int64_t>(), " ",
                  index[2].get<std::int64_t>(), ")");
  };
  if (grid.contains("first_active"))
    text += concat(" in ", corner(grid["first_active"]), " to ", corner(grid["last_active"]));
  if (grid.contains("background")) text += concat(", background ", rounded(grid["background"], 6));
  return text;
}

/// The counters of packing, and how packing treats what they count.
struct PackingRow {
  const char *key, *singular, *plural, *treatment;
};
constexpr PackingRow packing_rows[] = {
    {"dropped_cells", "cell", "cells", "dropped while packing"},
    {"dropped_facets", "facet", "facets", "dropped while packing"},
    {"unused_points", "unused point", "unused points", "dropped while packing"},
    {"flipped_cells", "cell", "cells", "of negative orientation turned while packing"},
    {"flat_cells", "cell", "cells", "of zero volume kept"},
    {"flat_triangles", "triangle", "triangles", "of zero area kept"}};

std::string packing_text(const Json& json) {
  std::string text;
  if (json.contains("packing")) {
    for (const PackingRow& kind : packing_rows)
      if (const std::uint64_t count = json["packing"].value(std::string(kind.key), std::uint64_t{0}); count != 0)
        text += row("packing", concat(counted(count, kind.singular, kind.plural), " ", kind.treatment));
  }
  if (json.contains("provenance")) {
    text += row("from", word(json["provenance"]["source_name"]));
    text += row("made by", word(json["provenance"]["command"]));
  }
  if (json.contains("notes"))
    for (const Json& note : json["notes"]) text += row("note", word(note));
  return text;
}

/// The faults found, and in one line those not found.
std::string findings_text(const Json& findings) {
  std::string text;
  std::vector<std::string> absent;
  for (const Json& finding : findings) {
    const auto count = finding["count"].get<std::uint64_t>();
    const std::string name = word(finding["name"]);
    if (count == 0) {
      absent.push_back(name);
      continue;
    }
    const std::string first = numbers(finding["first"], ", ");
    text += row("found", concat(name, ": ", grouped(count),
                                first.empty() ? ""
                                              : concat(" (", word(finding["of"]), " ", first,
                                                       count > finding["first"].size() ? ", ..." : "", ")"),
                                "; ", word(finding["packing"])));
  }
  return absent.empty() ? text : text + row("not found", joined(absent));
}

/// The same facts as text.
/// @param verbose  with what only those who look into the file's structure need
std::string info_text(const Json& json, bool verbose) {
  const std::string kind = word(json["kind"]);
  std::string text = concat(word(json["file"]), ": ", json["packed"].get<bool>() ? "packed " : "", kind, ", ",
                            bytes_text(json["file_bytes"]), "\n");
  if (json.contains("samples")) text += row("samples", numbers(json["samples"], " x "));
  if (json.contains("texels"))
    text += row("texels", concat(numbers(json["texels"], " x "), ", ", word(json["components"]), " of 8 bits (sRGB)"));
  for (const char* name : {"points", "cells", "facets", "triangles"})
    if (json.contains(name)) text += row(name, grouped(json[name]));
  text += geometry_text(json);
  if (verbose) text += layout_text(json);
  if (json.contains("grids"))
    for (const Json& grid : json["grids"]) text += row("grid", grid_text(grid));
  if (json.contains("fields"))
    for (const Json& field : json["fields"]) text += field_text(field, "field");
  if (json.contains("cell_fields"))
    for (const Json& field : json["cell_fields"]) text += field_text(field, "cells");
  if (json.contains("other_fields") && !json["other_fields"].empty())
    text += row("also", joined(json["other_fields"].get<std::vector<std::string>>(), ", ", "'"));
  if (json.contains("vectors"))
    for (const Json& array : json["vectors"])
      text += row("vector", concat("'", word(array["name"]), "'  ", array["components"].get<int>(),
                                   " components: ", word(array["scalars"])));
  if (json.contains("findings")) text += findings_text(json["findings"]);
  return text + packing_text(json);
}

/// Names, units and notes may come from a hostile file.
Json with_printable_texts(Json json) {
  if (json.is_string()) return printable(json.get_ref<const std::string&>());
  if (json.is_structured())
    for (Json& part : json) part = with_printable_texts(std::move(part));
  return json;
}

int run(const InfoOptions& options) {
  int result = 0;
  preprocess::PackOptions pack = pack_options(options.read);
  pack.memory_limit_bytes = options.common.memory.bytes;
  for (const std::filesystem::path& path : options.files) {
    try {
      preprocess::require_input(path);
      preprocess::refuse_pack_options(path, pack);
      const Json json = formats::PackedFile::looks_packed(path) || path.extension() == ".rho"
                            ? packed_info(path, options.findings)
                            : foreign_info(path, pack, options.findings);
      if (options.common.json)
        std::puts(dump(json).c_str());
      else
        std::fputs(info_text(with_printable_texts(json), options.common.verbose).c_str(), stdout);
    } catch (const Error& error) {
      std::fputs(error_lines("rhoray info", error.what(), error.hint()).c_str(), stderr);
      result = std::max(result, static_cast<int>(error.code()));
    }
  }
  return result;
}

}  // namespace

Subcommand info_subcommand() {
  const auto options = std::make_shared<InfoOptions>();
  return {.name = "info",
          .summary = "Show what a file contains",
          .group = "Files",
          .examples = {"rhoray info head.rho", "rhoray info head.rho torso.vtu --json", "rhoray info torso.vtu --stats",
                       "rhoray info head.rho -v"},
          .options =
              all_options({{files_option("FILE", "Packed files, volumes, meshes or surfaces", options->files),
                            flag_option("--stats", "Also look for faults in the data, and say how packing treats them",
                                        options->findings)},
                           read_options(options->read),
                           {worker_memory_option(options->common, "the process that reads a foreign file")},
                           message_options(options->common, "Print one JSON document per file to stdout, one per line",
                                           "Also print layout and memory")}),
          .run = [options] { return run(*options); }};
}

}  // namespace rhoray::tools
