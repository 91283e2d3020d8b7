#include "preprocess/tetrahedralize.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <optional>
#include <set>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/number_text.h"
#include "formats/base/pending_file.h"
#include "formats/base/word_list.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/input_file.h"
#include "preprocess/inspect_surface.h"
#include "preprocess/repair_surface.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

using preprocess::ForeignKind;
using preprocess::NeutralSurface;

struct TetrahedralizeCommand {
  CommonOptions common;
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path sizes;
  std::string max_volume;
  std::string size_field;
  preprocess::TetrahedralizeOptions fill;
  preprocess::RepairOptions repair;
  std::optional<double> max_move, time_limit_s;
  bool mend = false;
  bool no_regions = false;
  std::vector<preprocess::SourceFile> sources;  ///< the files that were read
};

/// A number of an option whose text has several.
double number_in(const std::string& option, const std::string& text) {
  double number = 0;
  try {
    read_value(text, number);
  } catch (const Error& error) {
    throw Error(ErrorCode::usage, concat(option, ": ", error.what()), error.hint());
  }
  return number;
}

/// V for all, R:V for one region; several between commas.
void read_max_volume(TetrahedralizeCommand& command) {
  if (command.max_volume.empty()) return;
  for (const std::string& piece : split(command.max_volume, ',')) {
    const std::vector<std::string> parts = split(piece, ':');
    if (parts.size() > 2)
      throw Error(ErrorCode::usage, concat("--max-volume: found '", piece, "'; expected V or REGION:V"));
    const double volume = number_in("--max-volume", parts.back());
    require_within("--max-volume", volume, 0, 1e300);
    if (parts.size() == 1)
      command.fill.max_volume = volume;
    else
      command.fill.region_volumes.push_back({.region = number_in("--max-volume", parts.front()), .max_volume = volume});
  }
}

void require_surface(const std::filesystem::path& input) {
  preprocess::require_input(input);
  if (preprocess::foreign_kind(input) == ForeignKind::surface) return;
  throw Error(ErrorCode::unsupported,
              concat(input.string(), ": is not a surface; expected ", preprocess::extensions_of(ForeignKind::surface)),
              formats::PackedFile::looks_packed(input) ? concat("show its content: rhoray info ", input.string())
                                                       : std::string{});
}

/// The option that replaces the surface by another one; empty = the surface stays as it is.
std::string remaking_option(const TetrahedralizeCommand& command) {
  if (command.repair.wrap > 0) return "--wrap";
  return command.mend ? "--repair" : "";
}

void check(const TetrahedralizeCommand& command, const std::filesystem::path& output) {
  for (const auto& input : command.inputs) {
    require_surface(input);
    require_writable(command.common, output, input);
  }
  if (!command.sizes.empty()) {
    if (const std::string remake = remaking_option(command); !remake.empty())
      throw Error(ErrorCode::usage, concat("--sizes: cannot be combined with ", remake, ", which changes the points"),
                  "--size-field gives sizes in space");
    preprocess::require_input(command.sizes);
    if (command.inputs.size() > 1)
      throw Error(ErrorCode::usage, "--sizes: needs exactly one surface; found several",
                  "--size-field gives sizes in space");
  }
  if (output.extension() != ".vtu")
    throw Error(ErrorCode::usage,
                concat(output.string(), ": found extension '", output.extension().string(), "'; expected .vtu"));
  if (command.fill.quality && *command.fill.quality != 0) require_within("--quality", *command.fill.quality, 1, 100);
  if (command.time_limit_s) require_within("--time-limit", *command.time_limit_s, 1, 1e7);
  if (command.max_move) require_within("--max-move", *command.max_move, 0, 1);
  require_within("--wrap", command.repair.wrap, 0, 1);
  if (command.repair.largest_part_only && !command.mend && command.repair.wrap == 0)
    throw Error(ErrorCode::usage, "--largest-part: needs --repair");
  if (command.max_move && (!command.mend || command.repair.wrap > 0))
    throw Error(ErrorCode::usage,
                concat("--max-move: needs --repair; found ", command.repair.wrap > 0 ? "--wrap" : "no --repair"));
}

/// Adds the file names to errors of the library functions, which do not know them.
template <class Act>
auto with_names(const TetrahedralizeCommand& command, Act act) {
  try {
    return act();
  } catch (const Error& error) {
    std::vector<std::string> names;
    for (const auto& input : command.inputs) names.push_back(input.string());
    throw Error(error.code(), concat(joined(names, " + "), ": ", error.what()), error.hint());
  }
}

NeutralSurface read_surfaces(const TetrahedralizeCommand& command, ProgressDisplay& display) {
  std::vector<NeutralSurface> surfaces;
  for (const auto& input : command.inputs) {
    display.show(concat("reading ", input.string()));
    surfaces.push_back(
        preprocess::import_surface(input, command.sizes, {.memory_limit_bytes = command.common.memory.bytes}));
  }
  if (surfaces.size() == 1) return std::move(surfaces.front());
  NeutralSurface all = preprocess::join(surfaces);
  std::uint64_t first = surfaces.front().facet_offsets.size() - 1;
  for (std::size_t i = 1; i < surfaces.size(); ++i) {
    all.notes.push_back(concat("facets of ", command.inputs[i].string(), " are numbered from ", first));
    first += surfaces[i].facet_offsets.size() - 1;
  }
  return all;
}

/// distance:FILE:NEAR:FAR:GROWTH, where FILE may hold colons itself.
preprocess::SizeByDistance read_size_by_distance(const TetrahedralizeCommand& command) {
  std::vector<std::string> parts = split(command.size_field, ':');
  if (parts.size() < 5)
    throw Error(ErrorCode::usage,
                concat("--size-field: found '", command.size_field, "'; expected distance:SURFACE:NEAR:FAR:GROWTH"));
  std::string file = parts[1];
  for (std::size_t i = 2; i + 3 < parts.size(); ++i) file += ":" + parts[i];
  require_surface(file);
  const auto number = [&](std::size_t from_end) { return number_in("--size-field", parts[parts.size() - from_end]); };
  preprocess::SizeByDistance sizes;  // filled below: gcc 12 frees a member twice when a later initialiser throws
  sizes.near = number(3);
  sizes.far = number(2);
  sizes.growth = number(1);
  sizes.surface = preprocess::import_surface(file, {}, {.memory_limit_bytes = command.common.memory.bytes});
  return sizes;
}

preprocess::NeutralMesh read_size_mesh(const std::filesystem::path& file, const std::string& field,
                                       std::uint64_t memory_limit_bytes) {
  preprocess::NeutralMesh mesh =
      preprocess::import_mesh(file, {.error_fields = field.empty() ? std::vector<std::string>{} : std::vector{field},
                                     .memory_limit_bytes = memory_limit_bytes});
  std::vector<std::string> names;
  for (const auto& f : mesh.point_fields)
    if (f.component_count == 1) names.push_back(f.name);
  if (names.empty() || (field.empty() && names.size() > 1))
    throw Error(ErrorCode::usage, concat("--size-field: ", file.string(), " has ", names.size(),
                                         " scalar point fields; expected one", names.empty() ? "" : ", or FILE:FIELD"));
  const std::string wanted = field.empty() ? names.front() : field;
  const auto found = std::find_if(mesh.point_fields.begin(), mesh.point_fields.end(),
                                  [&](const auto& f) { return f.component_count == 1 && f.name == wanted; });
  if (found == mesh.point_fields.end())
    throw Error(ErrorCode::usage, concat("--size-field: ", file.string(), " has no scalar point field '", wanted, "'"),
                did_you_mean(wanted, names));
  preprocess::NeutralField kept = std::move(*found);
  mesh.point_fields.clear();
  mesh.point_fields.push_back(std::move(kept));
  mesh.cell_fields.clear();
  return mesh;
}

/// A file, FILE:FIELD, or a function of distance.
preprocess::SizeField read_size_field(const TetrahedralizeCommand& command) {
  if (command.size_field.starts_with("distance:")) return read_size_by_distance(command);
  std::filesystem::path file = command.size_field;
  std::string field;
  std::error_code ignored;
  if (const std::size_t colon = command.size_field.rfind(':');
      colon != std::string::npos && !std::filesystem::exists(file, ignored)) {
    file = command.size_field.substr(0, colon);
    field = command.size_field.substr(colon + 1);
  }
  preprocess::require_input(file);
  const std::uint64_t memory = command.common.memory.bytes;
  switch (preprocess::foreign_kind(file)) {
    case ForeignKind::volume: {
      preprocess::ImportVolumeOptions options;
      options.field = field;
      options.memory_limit_bytes = memory;
      return preprocess::import_volume(file, options);
    }
    case ForeignKind::mesh:
      return read_size_mesh(file, field, memory);
    default:
      throw Error(ErrorCode::usage,
                  concat("--size-field: ", file.string(),
                         " is neither a volume nor a mesh; expected one, or distance:SURFACE:NEAR:FAR:GROWTH"));
  }
}

/// Notes files that were read. Refuses an output that is one of them.
void note_sources(TetrahedralizeCommand& command, const std::vector<preprocess::SourceFile>& sources,
                  const std::filesystem::path& output) {
  preprocess::require_not_read(output, sources);
  command.sources.insert(command.sources.end(), sources.begin(), sources.end());
}

std::vector<preprocess::SourceFile> sources_of(const preprocess::SizeField& sizes) {
  if (const auto* const by_distance = std::get_if<preprocess::SizeByDistance>(&sizes))
    return by_distance->surface.sources;
  if (const auto* const mesh = std::get_if<preprocess::NeutralMesh>(&sizes)) return mesh->sources;
  return std::get<preprocess::NeutralVolume>(sizes).sources;
}

/// Writes the faulty facets as PLY (text): every facet once for each fault, its number in the
/// surface as property `facet`, the kind of fault as property `fault`; comments name the kinds.
void write_fault_file(const std::filesystem::path& path, const preprocess::NeutralSurface& surface,
                      std::span<const preprocess::FaultyFacet> faults, bool replace_existing) {
  std::map<std::uint64_t, std::size_t> position;  // of the points that are used
  std::string points, facets;
  std::set<preprocess::FacetFault> kinds;
  std::size_t facet_count = 0;
  for (const auto& [facet, fault] : faults) {
    const std::uint64_t first = surface.facet_offsets[facet], last = surface.facet_offsets[facet + 1];
    kinds.insert(fault);
    ++facet_count;
    facets += concat(last - first);
    for (std::uint64_t i = first; i < last; ++i) {
      const std::uint64_t corner = surface.facet_corners[i];
      const auto [place, is_new] = position.try_emplace(corner, position.size());
      if (is_new) {
        const auto& p = surface.points[corner];
        points += concat(p[0], " ", p[1], " ", p[2], "\n");
      }
      facets += concat(" ", place->second);
    }
    facets += concat(" ", facet, " ", static_cast<unsigned>(fault), "\n");
  }
  std::string header = "ply\nformat ascii 1.0\ncomment facets for which a surface was refused\n";
  for (const preprocess::FacetFault kind : kinds)
    header += concat("comment fault ", static_cast<unsigned>(kind), ": ", preprocess::name_of(kind), "\n");
  header += concat("element vertex ", position.size(),
                   "\nproperty double x\nproperty double y\nproperty double z\nelement face ", facet_count,
                   "\nproperty list int int vertex_indices\nproperty uint facet\nproperty uchar fault\nend_header\n");
  write_whole_file(path, header + points + facets, replace_existing);
}

/// Writes the faulty facets to a file beside the output, and names it in the refusal.
[[noreturn]] void refuse_with_fault_file(const Error& refusal, const TetrahedralizeCommand& command,
                                         const NeutralSurface& surface, const std::filesystem::path& output) {
  const auto faults = preprocess::find_faults(surface, command.fill.solids_may_touch);
  const std::filesystem::path file = std::filesystem::path(output).replace_extension(".faults.ply");
  std::string where;
  if (!faults.empty() && preprocess::was_read(file, command.sources)) {
    where = concat("; ", file.string(), " is an input and was not changed");
  } else if (std::error_code ignored;
             !faults.empty() && std::filesystem::exists(file, ignored) && !command.common.force) {
    where = concat("; ", file.string(), " already exists and was not changed (use --force to overwrite it)");
  } else if (!faults.empty()) {
    write_fault_file(file, surface, faults, command.common.force);
    where = concat("; the faulty facets are in ", file.string());
  }
  const bool repaired = !remaking_option(command).empty();
  std::string hint = refusal.hint();
  hint += concat(hint.empty() ? "" : ", or ", repaired ? "--wrap 0.01 wraps it in a new closed surface"
                                              : faults.empty()
                                                  ? "--repair removes needles and flat facets, on which TetGen may fail"
                                                  : "--repair fixes what it can and reports how far the surface moved");
  throw Error(refusal.code(), refusal.what() + where, hint);
}

preprocess::NeutralMesh fill(const TetrahedralizeCommand& command, const NeutralSurface& surface,
                             const std::filesystem::path& output) {
  try {
    return preprocess::tetrahedralize(surface, command.fill);
  } catch (const Error& refusal) {
    if (refusal.code() != ErrorCode::invalid) throw;
    refuse_with_fault_file(refusal, command, surface, output);
  }
}

Json repair_json(const preprocess::RepairReport& r) {
  return {{"merged_points", r.merged_points},
          {"dropped_flat", r.dropped_flat},
          {"dropped_twins", r.dropped_twins},
          {"dropped_not_finite", r.dropped_not_finite},
          {"split_points", r.split_points},
          {"stitched_edges", r.stitched_edges},
          {"filled_holes", r.filled_holes},
          {"crossing_pairs", r.crossing_pairs},
          {"mended_parts", r.mended_parts},
          {"united_parts", r.united_parts},
          {"dropped_parts", r.dropped_parts},
          {"wrapped", r.wrapped},
          {"moved", r.moved},
          {"farthest_new_from_old", r.farthest_new_from_old},
          {"farthest_old_from_new", r.farthest_old_from_new},
          {"distance_error", r.distance_error},
          {"box_diagonal", r.box_diagonal}};
}

void settle_limits(TetrahedralizeCommand& command) {
  command.fill.regions = !command.no_regions;
  if (command.common.memory.bytes != 0)
    command.fill.memory_limit_bytes = command.repair.memory_limit_bytes = command.common.memory.bytes;
  if (command.time_limit_s) command.fill.time_limit_s = command.repair.time_limit_s = *command.time_limit_s;
  if (command.max_move) command.repair.max_move = *command.max_move;
}

int run(TetrahedralizeCommand& command) {
  const Stopwatch watch;
  const std::filesystem::path output = command.common.output.empty()
                                           ? std::filesystem::path(command.inputs.front()).replace_extension(".vtu")
                                           : command.common.output;
  check(command, output);
  read_max_volume(command);
  settle_limits(command);

  std::vector<std::string> notes;
  std::optional<preprocess::RepairReport> repair;
  preprocess::NeutralMesh mesh;
  {
    ProgressDisplay display(command.common);
    NeutralSurface surface = read_surfaces(command, display);
    notes = surface.notes;
    note_sources(command, surface.sources, output);
    if (!command.size_field.empty()) {
      display.show("reading the size field");
      command.fill.size_field = std::make_shared<const preprocess::SizeField>(read_size_field(command));
      note_sources(command, sources_of(*command.fill.size_field), output);
    }
    if (const std::string remake = remaking_option(command); !remake.empty()) {
      if (!surface.point_sizes.empty())
        notes.push_back(concat("the target sizes at the points (.mtr) are not used: ", remake,
                               " changes the points; --size-field gives sizes in space"));
      display.show(command.repair.wrap > 0 ? "wrapping the surface (CGAL)" : "repairing the surface (CGAL)");
      auto repaired = with_names(command, [&] { return preprocess::repair_surface(surface, command.repair); });
      surface = std::move(repaired.surface);
      repair = repaired.report;
      command.fill.solids_may_touch = true;
      display.clear();
      for (const std::string& note : surface.notes) say(command.common, concat("note: ", note));
    } else {
      surface.notes.clear();
    }
    display.show("filling with tetrahedra (TetGen)");
    mesh = with_names(command, [&] { return fill(command, surface, output); });
    for (const std::string& note : mesh.notes)
      if (std::find(surface.notes.begin(), surface.notes.end(), note) == surface.notes.end()) notes.push_back(note);
    display.show(concat("writing ", output.string()));
    preprocess::export_mesh(mesh, output, command.common.force);
  }

  const Usage usage = usage_so_far();
  for (const std::string& note : notes) say(command.common, concat("note: ", note));
  say(command.common, concat(output.string(), ": ", counted(mesh.cells.size(), "tetrahedron", "tetrahedra"), ", ",
                             counted(mesh.points.size(), "point", "points")));
  say(command.common, concat("took ", rounded(watch.seconds(), 3), " s, peak memory ", bytes_text(usage.peak_bytes),
                             ", in a worker ", bytes_text(usage.worker_peak_bytes)));
  if (command.common.json) {
    Json document{{"file", output.string()},
                  {"cells", mesh.cells.size()},
                  {"points", mesh.points.size()},
                  {"seconds", watch.seconds()},
                  {"peak_bytes", usage.peak_bytes},
                  {"worker_peak_bytes", usage.worker_peak_bytes},
                  {"notes", notes}};
    if (repair) document["repair"] = repair_json(*repair);
    std::puts(dump(document).c_str());
  }
  return 0;
}

}  // namespace

Subcommand tetrahedralize_subcommand() {
  const auto command = std::make_shared<TetrahedralizeCommand>();
  return {
      .name = "tetrahedralize",
      .summary = "Fill closed surfaces with tetrahedra (TetGen)",
      .group = "Meshes",
      .examples = {"rhoray tetrahedralize heart.ply -o heart.vtu",
                   "rhoray tetrahedralize scan.stl --repair -o scan.vtu",
                   "rhoray tetrahedralize scalp.tri skull.tri brain.tri --max-volume 1:50,3:20 -o head.vtu",
                   "rhoray tetrahedralize torso.ply --size-field distance:heart.ply:1:20:0.2 -o torso.vtu",
                   "rhoray tetrahedralize torso.smesh --quality 1.4 --sizes torso.mtr -o torso.vtu"},
      .options = all_options(
          {{with_details(files_option("SURFACE", "Surfaces: .ply, .stl, .obj, .off, .tri, .vtk, .poly, .smesh or .face",
                                      command->inputs),
                         "Nested surfaces make regions, numbered from the outside")},
           in_group("Repair",
                    {with_details(
                         flag_option("--repair", "Repair a faulty surface, and report how far it moved", command->mend),
                         "Merges, drops, orients and stitches parts, fills holes and resolves self-intersections"),
                     value_option("--max-move", "SHARE",
                                  "With --repair: largest movement, as a share of the box diagonal; default 0.02",
                                  command->max_move),
                     flag_option("--largest-part", "With --repair: keep only the connected part with the largest area",
                                 command->repair.largest_part_only),
                     with_details(
                         value_option("--wrap", "SHARE", "Instead of --repair: wrap the surface in a new closed one",
                                      command->repair.wrap),
                         "The new surface bridges gaps up to this share of the box diagonal")}),
           in_group(
               "Tetrahedra",
               {with_details(value_option("--quality", "R",
                                          "Largest ratio of circumradius to shortest edge; 0 adds no points; default "
                                          "1.4 where the surface allows it",
                                          command->fill.quality),
                             "A note reports the ratio reached. Without this option and without sizes, there are at "
                             "most 20 tetrahedra per triangle"),
                value_option("--max-volume", "V",
                             "Largest volume of a tetrahedron: V, or REGION:V,... for single regions; default 0, no "
                             "limit",
                             command->max_volume),
                value_option("--size-field", "FIELD",
                             "Target edge lengths: a volume FILE, a mesh FILE:FIELD, or "
                             "distance:SURFACE:NEAR:FAR:GROWTH",
                             command->size_field),
                with_details(value_option("--sizes", "FILE",
                                          "Target sizes at the points (.mtr); default the .mtr beside the surface",
                                          command->sizes),
                             "Not with --repair or --wrap, which change the points"),
                flag_option("--cavities", "Leave every second one of nested surfaces empty inside",
                            command->fill.empty_cavities),
                for_experts({Option::Kind::flag, "--regions", "",
                             "Number the regions in cell field 'region' (the default)",
                             [command](const std::string&) { command->no_regions = false; }}),
                for_experts(flag_option("--no-regions", "Do not number the regions", command->no_regions)),
                for_experts(with_details(value_option("--tetgen", "SWITCHES",
                                                      "More switches for TetGen, of Y O S T X M", command->fill.tetgen),
                                         "Y keeps the surface's triangles. S100 adds at most 100 points"))}),
           in_group("Output", output_options(command->common, "Mesh (.vtu); default the first input's name with .vtu")),
           in_group("General",
                    all_options({{for_experts(value_option(
                                      "--time-limit", "SECONDS",
                                      "CPU time limit of each worker; default 3600 for TetGen, 300 for CGAL",
                                      command->time_limit_s)),
                                  memory_option(command->common,
                                                "Memory limit of each worker process; default 8G for TetGen and CGAL")},
                                 message_options(command->common, "Print a JSON summary to stdout")}))}),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools
