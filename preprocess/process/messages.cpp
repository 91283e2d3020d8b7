#include "preprocess/process/messages.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <type_traits>

#include "formats/base/bytes.h"
#include "formats/format_error.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/message_parts.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
using formats::PackedFile;
using message::MessageReader;
using message::MessageWriter;

// Descriptions: what a message holds, in order. The writer and the reader follow the same one.

template <class Message, class Mesh>
void describe_fields(Message& message, Mesh& mesh, std::uint64_t cell_count) {
  message.text(mesh.length_unit);
  message.fields("point_fields", mesh.point_fields, mesh.points.size());
  message.fields("cell_fields", mesh.cell_fields, cell_count);
  message.sources(mesh.sources);
  message.rest_of_texts(mesh.notes);
}

template <class Message, class Mesh>
void describe_cells(Message& message, Mesh& mesh) {
  message.array("points", mesh.points);
  message.array("kinds", mesh.kinds);
  message.array("cell_offsets", mesh.cell_offsets);
  message.array("cell_nodes", mesh.cell_nodes);
  message.array("cell_ids", mesh.cell_ids);
  describe_fields(message, mesh, mesh.kinds.size());
}

template <class Message, class Mesh>
void describe_tetrahedra(Message& message, Mesh& mesh) {
  message.array("points", mesh.points);
  message.array("cells", mesh.cells);
  message.array("cell_ids", mesh.cell_ids);
  describe_fields(message, mesh, mesh.cells.size());
}

template <class Message, class Surface>
void describe_surface(Message& message, Surface& surface) {
  message.array("points", surface.points);
  message.array("point_sizes", surface.point_sizes);
  message.array("facet_offsets", surface.facet_offsets);
  message.array("facet_corners", surface.facet_corners);
  message.array("facet_faces", surface.facet_faces);
  message.array("holes", surface.holes);
  message.array("regions", surface.regions);
  std::vector<std::uint64_t> faces;
  std::vector<std::array<double, 3>> seeds;
  for (const NeutralSurface::Opening& opening : surface.openings) {
    faces.push_back(opening.face);
    seeds.push_back(opening.seed);
  }
  message.copy("opening_faces", faces);
  message.copy("opening_seeds", seeds);
  message.sources(surface.sources);
  message.rest_of_texts(surface.notes);
  if constexpr (!std::is_const_v<Surface>) {
    message.expect(faces.size() == seeds.size(), "array 'opening_faces'", "another size", "one for each seed");
    for (std::size_t i = 0; i < faces.size(); ++i) surface.openings.push_back({faces[i], seeds[i]});
  }
}

/// Reads or writes the names, axes and notes of a volume.
template <class Message, class Volume>
void describe_names(Message& message, Volume& volume) {
  message.text(volume.length_unit);
  std::string space(formats::space_word(volume.space));
  message.text(space);
  message.text(volume.field_name);
  message.text(volume.field_unit);
  message.label_names(volume.label_names);
  message.counted_texts(volume.other_fields);
  std::vector<std::string> names;
  std::vector<std::uint64_t> component_counts;
  for (const VectorArray& array : volume.vectors) {
    names.push_back(array.name);
    component_counts.push_back(static_cast<std::uint64_t>(array.component_count));
  }
  message.counted_texts(names);
  message.copy("vectors", component_counts);
  for (std::size_t axis = 0; axis < 3; ++axis) message.array(concat("axis.", axis), volume.axes[axis]);
  message.sources(volume.sources);
  message.rest_of_texts(volume.notes);
  if constexpr (!std::is_const_v<Volume>) {
    const std::optional<formats::Space> known = formats::space_named(space);
    message.expect(known.has_value(), "array 'texts'", concat("the space '", space, "'"), "RAS, LPS or none");
    volume.space = *known;
    message.expect(names.size() == component_counts.size(), "array 'vectors'", "another number",
                   "one for each array of several components");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::uint64_t count = component_counts[i];
      message.expect(count >= 2 && count <= std::numeric_limits<std::int32_t>::max(), "array 'vectors'",
                     "an absurd count", "2 to 2^31 - 1");
      volume.vectors.push_back({names[i], static_cast<int>(count)});
    }
  }
}

std::vector<std::array<double, 3>> axes_of(const Affine& map) {
  const auto row = [](const Vec3& v) { return std::array{v.x, v.y, v.z}; };
  return {row(map.x_axis), row(map.y_axis), row(map.z_axis), row(map.origin)};
}

Affine affine_of(const std::vector<std::array<double, 3>>& rows) {
  const auto vector = [](const std::array<double, 3>& v) { return Vec3(v[0], v[1], v[2]); };
  return {vector(rows[0]), vector(rows[1]), vector(rows[2]), vector(rows[3])};
}

}  // namespace

void send(const NeutralVolume& volume, int descriptor) {
  MessageWriter message;
  const Index3& n = volume.sample_count;
  const bool in_file = !volume.samples_file.empty();  // then only their location is sent
  const std::vector<std::uint64_t> facts{static_cast<std::uint64_t>(n.x),
                                         static_cast<std::uint64_t>(n.y),
                                         static_cast<std::uint64_t>(n.z),
                                         static_cast<std::uint64_t>(volume.type),
                                         in_file ? 1U : 0U,
                                         volume.samples_first_byte,
                                         static_cast<std::uint64_t>(volume.component_count)};
  message.array("facts", facts);
  if (!in_file) message.add("samples", volume.type, {facts[2], facts[1], facts[0], facts[6]}, volume.samples);
  message.copy("world_from_grid", axes_of(volume.world_from_grid));
  message.text(volume.samples_file.string());
  describe_names(message, volume);
  message.write("neutral-volume", descriptor);
}

namespace {

/// Delimiters of names in a header.
bool may_end_name(char letter) {
  return letter == '=' || letter == ':' || letter == '"' || letter == '\'' || letter == '\0' ||
         std::isspace(static_cast<unsigned char>(letter)) != 0;
}

bool holds_name(std::string_view text, const std::string& name) {
  for (std::size_t at = 0; !name.empty() && (at = text.find(name, at)) != std::string_view::npos; ++at) {
    const std::size_t end = at + name.size();
    if ((at == 0 || may_end_name(text[at - 1])) && (end == text.size() || may_end_name(text[end]))) return true;
  }
  return false;
}

/// True when `named` is the requested file, or its text names it.
bool belongs_to(const std::filesystem::path& source, const std::filesystem::path& named) {
  if (named == source) return true;
  constexpr std::size_t longest_header = std::size_t{16} << 20;
  const ForeignFile header(source);
  const std::string_view text = header.text().substr(0, longest_header);
  const std::string folder = (source.parent_path() / "").string(), whole = named.string();
  return holds_name(text, whole) || (whole.starts_with(folder) && holds_name(text, whole.substr(folder.size())));
}

constexpr auto last_type = static_cast<std::uint64_t>(ElementType::F64);

/// Maps samples that were left in the foreign file.
void map_samples(const MessageReader& message, NeutralVolume& volume, std::uint64_t first_byte) {
  const ForeignFile source(volume.samples_file);
  const Index3& n = volume.sample_count;
  const auto bytes = checked_product(
      {static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y), static_cast<std::uint64_t>(n.z),
       static_cast<std::uint64_t>(volume.component_count), formats::element_bytes(volume.type)});
  message.expect(bytes && first_byte <= source.bytes().size() && *bytes <= source.bytes().size() - first_byte,
                 "array 'facts'", "samples beyond the end of their file", "samples within it");
  volume.samples = source.bytes().subspan(first_byte, *bytes);
  volume.mapping = source.mapping();
  volume.samples_first_byte = first_byte;
}

void take_samples(const PackedFile& file, const MessageReader& message, NeutralVolume& volume,
                  const std::vector<std::uint64_t>& facts) {
  const formats::ArrayEntry& entry = file.entry("samples");
  message.expect(
      entry.shape == std::vector<std::uint64_t>{facts[2], facts[1], facts[0], facts[6]} && entry.type == volume.type,
      "array 'samples'", "another shape or type", "what 'facts' says");
  volume.samples = file.bytes("samples");
  volume.mapping = std::make_shared<const PackedFile>(file);
}

/// @param source  the file that may hold samples, or name one that does; null: any may
NeutralVolume volume_of(const PackedFile& file, const std::filesystem::path* source) {
  MessageReader message(file, "neutral-volume");
  NeutralVolume volume;
  std::vector<std::uint64_t> facts;
  message.array("facts", facts);
  message.expect(facts.size() == 7 && facts[3] <= last_type, "array 'facts'", "other facts", "sizes, type and place");
  message.expect(facts[6] == 1 || facts[6] == 3 || facts[6] == 4, "array 'facts'",
                 "a count of components that no one has", "1, 3 or 4");
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t count = facts[static_cast<std::size_t>(axis)];
    message.expect(count >= 1 && count <= std::uint64_t{1} << 40, "array 'facts'", "an absurd size", "1 to 2^40");
    volume.sample_count[axis] = static_cast<std::int64_t>(count);
  }
  volume.type = static_cast<ElementType>(facts[3]);
  volume.component_count = static_cast<int>(facts[6]);
  volume.samples_file = message.next_text();
  message.expect((facts[4] != 0) == !volume.samples_file.empty(), "array 'facts'", "no file", "one for the samples");
  if (facts[4] != 0 && source != nullptr && !belongs_to(*source, volume.samples_file))
    throw Error(ErrorCode::internal, concat(file.name(), ": names the file ", volume.samples_file.string(),
                                            " as that of its samples; expected ", source->string(),
                                            ", which was asked about, or a file that it names"));
  if (facts[4] != 0)
    map_samples(message, volume, facts[5]);
  else
    take_samples(file, message, volume, facts);
  std::vector<std::array<double, 3>> axes;
  message.array("world_from_grid", axes);
  message.expect(axes.size() == 4, "array 'world_from_grid'", "another shape", "4 x 3");
  message.expect(
      std::all_of(axes.begin(), axes.end(), [](const auto& row) { return std::isfinite(row[0] + row[1] + row[2]); }),
      "array 'world_from_grid'", "a number that is not finite", "finite numbers");
  volume.world_from_grid = affine_of(axes);
  describe_names(message, volume);
  for (std::size_t axis = 0; axis < 3; ++axis)
    message.expect(volume.axes[axis].empty() || volume.axes[axis].size() == facts[axis], "axis positions",
                   "another number", "one for each sample of the axis, or none");
  return volume;
}

bool is_known(CellKind kind) {
  constexpr std::pair<CellKind, CellKind> runs[] = {
      {CellKind::tetrahedron, CellKind::hexagonal_prism},
      {CellKind::quadratic_tetrahedron, CellKind::quadratic_pyramid},
      {CellKind::triquadratic_hexahedron, CellKind::triquadratic_hexahedron},
      {CellKind::quadratic_linear_wedge, CellKind::biquadratic_quadratic_hexahedron},
      {CellKind::triquadratic_pyramid, CellKind::triquadratic_pyramid},
      {CellKind::polyhedron, CellKind::polyhedron},
      {CellKind::lagrange_tetrahedron, CellKind::lagrange_pyramid},
      {CellKind::quadratic_pyramid_14, CellKind::quadratic_tetrahedron_14}};
  return std::any_of(std::begin(runs), std::end(runs),
                     [&](const auto& run) { return run.first <= kind && kind <= run.second; });
}

/// Offsets of lists: from 0 to the number of what they hold.
bool are_offsets(const Array<std::uint64_t>& offsets, std::size_t number) {
  return !offsets.empty() && offsets.front() == 0 && offsets.back() == number &&
         std::is_sorted(offsets.begin(), offsets.end());
}

void check_cell_ids(const MessageReader& message, const Array<std::uint64_t>& ids, std::size_t cell_count) {
  message.expect(ids.empty() || ids.size() == cell_count, "array 'cell_ids'", "another size", "one for each cell");
}

void check_faces(const MessageReader& message, const NeutralSurface& surface) {
  const Array<std::uint64_t>& faces = surface.facet_faces;
  message.expect(faces.empty() || faces.size() + 1 == surface.facet_offsets.size(), "array 'facet_faces'",
                 "another size", "one for each facet");
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const std::uint64_t before = i == 0 ? 0 : faces[i - 1];
    message.expect(faces[i] == before || (i > 0 && faces[i] == before + 1), "array 'facet_faces'", "a jump",
                   "0, 1, 2, ...");
  }
  for (const NeutralSurface::Opening& opening : surface.openings)
    message.expect(!faces.empty() && opening.face <= faces.back(), "array 'opening_faces'", "a face that is not there",
                   "a number of facet_faces");
}

}  // namespace

NeutralVolume receive_volume(const PackedFile& file) {
  return volume_of(file, nullptr);
}

NeutralVolume receive_volume(const PackedFile& file, const std::filesystem::path& source) {
  return volume_of(file, &source);
}

void send(const CellMesh& mesh, int descriptor) {
  MessageWriter message;
  describe_cells(message, mesh);
  message.write("neutral-cells", descriptor);
}

CellMesh receive_cell_mesh(const PackedFile& file) {
  MessageReader message(file, "neutral-cells");
  CellMesh mesh;
  describe_cells(message, mesh);
  message.expect(std::all_of(mesh.kinds.begin(), mesh.kinds.end(), is_known), "array 'kinds'",
                 "a kind of cell that is not known", "one of CellKind");
  message.expect(
      mesh.cell_offsets.size() == mesh.kinds.size() + 1 && are_offsets(mesh.cell_offsets, mesh.cell_nodes.size()),
      "array 'cell_offsets'", "offsets that do not fit", "rising from 0 to the number of nodes");
  check_cell_ids(message, mesh.cell_ids, mesh.kinds.size());
  return mesh;
}

void send(const NeutralMesh& mesh, int descriptor) {
  MessageWriter message;
  describe_tetrahedra(message, mesh);
  message.write("neutral-mesh", descriptor);
}

NeutralMesh receive_mesh(const PackedFile& file) {
  MessageReader message(file, "neutral-mesh");
  NeutralMesh mesh;
  describe_tetrahedra(message, mesh);
  check_cell_ids(message, mesh.cell_ids, mesh.cells.size());
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    for (const std::uint64_t vertex : mesh.cells[cell])
      if (vertex >= mesh.points.size())
        formats::refuse(file.name(), concat("array 'cells', cell ", cell), concat("point ", vertex),
                        concat("a number below ", mesh.points.size()));
  return mesh;
}

void send(const NeutralSurface& surface, int descriptor) {
  MessageWriter message;
  describe_surface(message, surface);
  message.write("neutral-surface", descriptor);
}

NeutralSurface receive_surface(const PackedFile& file) {
  MessageReader message(file, "neutral-surface");
  NeutralSurface surface;
  describe_surface(message, surface);
  message.expect(are_offsets(surface.facet_offsets, surface.facet_corners.size()), "array 'facet_offsets'",
                 "offsets that do not fit", "rising from 0 to the number of corners");
  message.expect(std::all_of(surface.facet_corners.begin(), surface.facet_corners.end(),
                             [&](std::uint64_t corner) { return corner < surface.points.size(); }),
                 "array 'facet_corners'", "a point that is not there", "positions below the number of points");
  message.expect(surface.point_sizes.empty() || surface.point_sizes.size() == surface.points.size(),
                 "array 'point_sizes'", "another size", "one for each point");
  check_faces(message, surface);
  return surface;
}

}  // namespace rhoray::preprocess
