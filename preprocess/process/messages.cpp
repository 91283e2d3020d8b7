#include "preprocess/process/messages.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/base/bytes.h"
#include "formats/format_error.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ArraySpec;
using formats::ElementType;
using formats::PackedFile;
using formats::PackedFileWriter;

/// Gathers arrays first, then declares and writes them at once. Empty arrays are left out.
class MessageWriter {
 public:
  template <class T>
  void add(const std::string& name, std::vector<std::uint64_t> shape, const T* values, std::uint64_t count) {
    add(name, formats::element_type_of<T>(), std::move(shape), std::as_bytes(std::span(values, count)));
  }
  template <class T>
  void add(const std::string& name, const Array<T>& values) {
    add(name, {values.size()}, values.data(), values.size());
  }
  template <class T, std::size_t N>
  void add(const std::string& name, const Array<std::array<T, N>>& rows) {
    add(name, {rows.size(), N}, rows.empty() ? nullptr : rows.front().data(), rows.size() * N);
  }
  void add(const std::string& name, ElementType type, std::vector<std::uint64_t> shape,
           std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    specs_.push_back({.name = name, .type = type, .shape = std::move(shape), .alignment = 64});
    contents_.push_back(bytes);
  }
  /// The texts are copied into this object; a text ends at its first NUL.
  void add_texts(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      joined_.insert(joined_.end(), text.c_str(), text.c_str() + std::strlen(text.c_str()) + 1);
    }
    add("texts", joined_);
  }

  void write(const char* kind, int descriptor) const {
    formats::FileDescription description;
    description.kind = kind;
    PackedFileWriter writer(descriptor, description, specs_);
    for (std::size_t i = 0; i < specs_.size(); ++i) writer.write(specs_[i].name, 0, contents_[i]);
    writer.commit();
  }

 private:
  std::vector<ArraySpec> specs_;
  std::vector<std::span<const std::byte>> contents_;
  Array<std::uint8_t> joined_;
};

/// Reads what a MessageWriter wrote.
class MessageReader {
 public:
  MessageReader(const PackedFile& file, const char* kind) : file_(file) {
    if (file.description().kind != kind) formats::refuse(file.name(), "header", file.description().kind, kind);
    split_texts();
  }

  template <class T>
  Array<T> values(const char* name) const {
    if (!file_.has(name)) return {};
    const std::span<const T> all = file_.array<T>(name, {0});
    return {all.begin(), all.end()};
  }
  template <class T, std::size_t N>
  Array<std::array<T, N>> rows(const char* name) const {
    if (!file_.has(name)) return {};
    const std::span<const T> all = file_.array<T>(name, {0, N});
    Array<std::array<T, N>> result(all.size() / N);
    std::memcpy(result.data(), all.data(), all.size_bytes());
    return result;
  }

  std::string next_text() {
    if (next_ == texts_.size()) formats::refuse(file_.name(), "array 'texts'", "too few texts", "one for each name");
    return texts_[next_++];
  }
  std::size_t next_count() {
    std::size_t count = 0;
    const std::string text = next_text();
    const auto read = std::from_chars(text.data(), text.data() + text.size(), count);
    expect(read.ec == std::errc() && count <= texts_.size(), "array 'texts'", "no count of names", "a count");
    return count;
  }
  std::vector<std::string> remaining_texts() {
    std::vector<std::string> rest(texts_.begin() + static_cast<std::ptrdiff_t>(next_), texts_.end());
    next_ = texts_.size();
    return rest;
  }

  void expect(bool holds, const char* place, const char* found, const char* expected) const {
    if (!holds) formats::refuse(file_.name(), place, found, expected);
  }

 private:
  void split_texts() {
    if (!file_.has("texts")) return;
    const std::span<const std::uint8_t> joined = file_.array<std::uint8_t>("texts", {0});
    if (joined.empty()) return;
    if (joined.back() != 0) formats::refuse(file_.name(), "array 'texts'", "an unfinished text", "a NUL at its end");
    for (auto begin = joined.begin(); begin != joined.end();) {
      const auto end = std::find(begin, joined.end(), 0);
      texts_.emplace_back(begin, end);
      begin = end + 1;
    }
  }

  const PackedFile& file_;
  std::vector<std::string> texts_;
  std::size_t next_ = 0;
};

/// Adds a list of fields: facts "<list>" [n, 2], values "<list>.0" ..., names and units among the
/// texts.
void add_fields(MessageWriter& parcel, const std::string& list, const std::vector<NeutralField>& fields,
                Array<std::array<std::uint64_t, 2>>& facts, std::vector<std::string>& texts) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const NeutralField& field = fields[i];
    const auto components = static_cast<std::uint64_t>(field.component_count);
    facts.push_back({components, field.was_single_precision ? 1U : 0U});
    texts.push_back(field.name);
    texts.push_back(field.unit);
    parcel.add(concat(list, ".", i), {field.values.size() / components, components}, field.values.data(),
               field.values.size());
  }
  parcel.add(list, facts);
}

std::vector<NeutralField> take_fields(const PackedFile& file, MessageReader& parcel, const char* list,
                                      std::uint64_t owners) {
  std::vector<NeutralField> fields;
  for (const auto& [components, single] : parcel.rows<std::uint64_t, 2>(list)) {
    parcel.expect(components >= 1 && components <= 1024, list, "a field without usable components", "1 to 1024");
    const std::string values = concat(list, ".", fields.size());
    NeutralField& field = fields.emplace_back();
    field.name = parcel.next_text();
    field.unit = parcel.next_text();
    field.component_count = static_cast<int>(components);
    field.was_single_precision = single != 0;
    if (owners == 0) continue;
    const std::span<const double> all = file.array<double>(values, {owners, components});
    field.values.assign(all.begin(), all.end());
  }
  return fields;
}

Array<std::array<double, 3>> axes_of(const Affine& map) {
  const auto row = [](const Vec3& v) { return std::array{v.x, v.y, v.z}; };
  return {row(map.x_axis), row(map.y_axis), row(map.z_axis), row(map.origin)};
}

Affine affine_of(const Array<std::array<double, 3>>& rows) {
  const auto vector = [](const std::array<double, 3>& v) { return Vec3(v[0], v[1], v[2]); };
  return {vector(rows[0]), vector(rows[1]), vector(rows[2]), vector(rows[3])};
}

}  // namespace

void send(const NeutralVolume& volume, int descriptor) {
  MessageWriter parcel;
  const Index3& n = volume.sample_count;
  const bool in_file = !volume.samples_file.empty();  // then only their location is sent
  const Array<std::uint64_t> facts{static_cast<std::uint64_t>(n.x),
                                   static_cast<std::uint64_t>(n.y),
                                   static_cast<std::uint64_t>(n.z),
                                   static_cast<std::uint64_t>(volume.type),
                                   in_file ? 1U : 0U,
                                   volume.samples_first_byte,
                                   static_cast<std::uint64_t>(volume.component_count)};
  parcel.add("facts", facts);
  if (!in_file) parcel.add("samples", volume.type, {facts[2], facts[1], facts[0], facts[6]}, volume.samples);
  const Array<std::array<double, 3>> axes = axes_of(volume.world_from_grid);
  parcel.add("world_from_grid", axes);
  std::array<Array<double>, 3> positions;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    positions[axis].assign(volume.axes[axis].begin(), volume.axes[axis].end());
    parcel.add(concat("axis.", axis), positions[axis]);
  }
  std::vector<std::string> texts{volume.samples_file.string(), volume.length_unit, volume.field_name, volume.field_unit,
                                 concat(volume.other_fields.size())};
  texts.insert(texts.end(), volume.other_fields.begin(), volume.other_fields.end());
  texts.push_back(concat(volume.vectors.size()));
  Array<std::uint64_t> component_counts;
  for (const VectorArray& array : volume.vectors) {
    texts.push_back(array.name);
    component_counts.push_back(static_cast<std::uint64_t>(array.component_count));
  }
  parcel.add("vectors", component_counts);
  texts.insert(texts.end(), volume.notes.begin(), volume.notes.end());
  parcel.add_texts(texts);
  parcel.write("neutral-volume", descriptor);
}

namespace {

void take_axes(const MessageReader& parcel, NeutralVolume& volume) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Array<double> positions = parcel.values<double>(concat("axis.", axis).c_str());
    const auto count = static_cast<std::size_t>(volume.sample_count[static_cast<int>(axis)]);
    parcel.expect(positions.empty() || positions.size() == count, "axis positions", "another number",
                  "one for each sample of the axis, or none");
    volume.axes[axis].assign(positions.begin(), positions.end());
  }
}

void take_vectors(MessageReader& parcel, NeutralVolume& volume) {
  const Array<std::uint64_t> component_counts = parcel.values<std::uint64_t>("vectors");
  parcel.expect(parcel.next_count() == component_counts.size(), "array 'vectors'", "another number",
                "one for each array of several components");
  for (const std::uint64_t count : component_counts) {
    parcel.expect(count >= 2 && count <= std::numeric_limits<std::int32_t>::max(), "array 'vectors'", "an absurd count",
                  "2 to 2^31 - 1");
    volume.vectors.push_back({parcel.next_text(), static_cast<int>(count)});
  }
}

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
void map_samples(const MessageReader& parcel, NeutralVolume& volume, std::uint64_t first_byte) {
  const ForeignFile source(volume.samples_file);
  const Index3& n = volume.sample_count;
  const auto bytes = checked_product(
      {static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y), static_cast<std::uint64_t>(n.z),
       static_cast<std::uint64_t>(volume.component_count), formats::element_bytes(volume.type)});
  parcel.expect(bytes && first_byte <= source.bytes().size() && *bytes <= source.bytes().size() - first_byte,
                "array 'facts'", "samples beyond the end of their file", "samples within it");
  volume.samples = source.bytes().subspan(first_byte, *bytes);
  volume.mapping = source.mapping();
  volume.samples_first_byte = first_byte;
}

void take_samples(const PackedFile& file, const MessageReader& parcel, NeutralVolume& volume) {
  const Index3& n = volume.sample_count;
  const formats::ArrayEntry& entry = file.entry("samples");
  const std::vector<std::uint64_t> shape{static_cast<std::uint64_t>(n.z), static_cast<std::uint64_t>(n.y),
                                         static_cast<std::uint64_t>(n.x),
                                         static_cast<std::uint64_t>(volume.component_count)};
  parcel.expect(entry.shape == shape && entry.type == volume.type, "array 'samples'", "another shape or type",
                "what 'facts' says");
  volume.samples = file.bytes("samples");
  volume.mapping = std::make_shared<const PackedFile>(file);
}

}  // namespace

namespace {

/// @param source  the file that may hold samples, or name one that does; null: any may
NeutralVolume volume_of(const PackedFile& file, const std::filesystem::path* source) {
  MessageReader parcel(file, "neutral-volume");
  NeutralVolume volume;
  const Array<std::uint64_t> facts = parcel.values<std::uint64_t>("facts");
  parcel.expect(facts.size() == 7 && facts[3] <= last_type, "array 'facts'", "other facts", "sizes, type and place");
  parcel.expect(facts[6] == 1 || facts[6] == 3 || facts[6] == 4, "array 'facts'",
                "a count of components that no one has", "1, 3 or 4");
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t count = facts[static_cast<std::size_t>(axis)];
    parcel.expect(count >= 1 && count <= std::uint64_t{1} << 40, "array 'facts'", "an absurd size", "1 to 2^40");
    volume.sample_count[axis] = static_cast<std::int64_t>(count);
  }
  volume.type = static_cast<ElementType>(facts[3]);
  volume.component_count = static_cast<int>(facts[6]);
  volume.samples_file = parcel.next_text();
  parcel.expect((facts[4] != 0) == !volume.samples_file.empty(), "array 'facts'", "no file", "one for the samples");
  if (facts[4] != 0 && source != nullptr && !belongs_to(*source, volume.samples_file))
    throw Error(ErrorCode::internal, concat(file.name(), ": names the file ", volume.samples_file.string(),
                                            " as that of its samples; expected ", source->string(),
                                            ", which was asked about, or a file that it names"));
  if (facts[4] != 0)
    map_samples(parcel, volume, facts[5]);
  else
    take_samples(file, parcel, volume);
  const auto axes = parcel.rows<double, 3>("world_from_grid");
  parcel.expect(axes.size() == 4, "array 'world_from_grid'", "another shape", "4 x 3");
  parcel.expect(
      std::all_of(axes.begin(), axes.end(), [](const auto& row) { return std::isfinite(row[0] + row[1] + row[2]); }),
      "array 'world_from_grid'", "a number that is not finite", "finite numbers");
  volume.world_from_grid = affine_of(axes);
  volume.length_unit = parcel.next_text();
  volume.field_name = parcel.next_text();
  volume.field_unit = parcel.next_text();
  for (std::size_t count = parcel.next_count(); count != 0; --count) volume.other_fields.push_back(parcel.next_text());
  take_vectors(parcel, volume);
  take_axes(parcel, volume);
  volume.notes = parcel.remaining_texts();
  return volume;
}

}  // namespace

NeutralVolume receive_volume(const PackedFile& file) {
  return volume_of(file, nullptr);
}

NeutralVolume receive_volume(const PackedFile& file, const std::filesystem::path& source) {
  return volume_of(file, &source);
}

void send(const CellMesh& mesh, int descriptor) {
  MessageWriter parcel;
  parcel.add("points", mesh.points);
  parcel.add("kinds", {mesh.kinds.size()}, reinterpret_cast<const std::uint8_t*>(mesh.kinds.data()), mesh.kinds.size());
  parcel.add("cell_offsets", mesh.cell_offsets);
  parcel.add("cell_nodes", mesh.cell_nodes);
  parcel.add("cell_ids", mesh.cell_ids);
  Array<std::array<std::uint64_t, 2>> point_facts, cell_facts;
  std::vector<std::string> texts{mesh.length_unit};
  add_fields(parcel, "point_fields", mesh.point_fields, point_facts, texts);
  add_fields(parcel, "cell_fields", mesh.cell_fields, cell_facts, texts);
  texts.insert(texts.end(), mesh.notes.begin(), mesh.notes.end());
  parcel.add_texts(texts);
  parcel.write("neutral-cells", descriptor);
}

namespace {

bool is_known(std::uint8_t number) {
  switch (static_cast<CellKind>(number)) {
    case CellKind::tetrahedron:
    case CellKind::voxel:
    case CellKind::hexahedron:
    case CellKind::wedge:
    case CellKind::pyramid:
    case CellKind::pentagonal_prism:
    case CellKind::hexagonal_prism:
    case CellKind::quadratic_tetrahedron:
    case CellKind::quadratic_hexahedron:
    case CellKind::quadratic_wedge:
    case CellKind::quadratic_pyramid:
    case CellKind::triquadratic_hexahedron:
    case CellKind::quadratic_linear_wedge:
    case CellKind::biquadratic_quadratic_wedge:
    case CellKind::biquadratic_quadratic_hexahedron:
    case CellKind::triquadratic_pyramid:
    case CellKind::polyhedron:
    case CellKind::lagrange_tetrahedron:
    case CellKind::lagrange_hexahedron:
    case CellKind::lagrange_wedge:
    case CellKind::lagrange_pyramid:
    case CellKind::quadratic_pyramid_14:
    case CellKind::quadratic_tetrahedron_14:
      return true;
  }
  return false;
}

void check_cells(const MessageReader& parcel, const CellMesh& mesh) {
  const Array<std::uint64_t>& offsets = mesh.cell_offsets;
  parcel.expect(offsets.size() == mesh.kinds.size() + 1 && offsets.front() == 0 &&
                    offsets.back() == mesh.cell_nodes.size() && std::is_sorted(offsets.begin(), offsets.end()),
                "array 'cell_offsets'", "offsets that do not fit", "rising from 0 to the number of nodes");
  parcel.expect(mesh.cell_ids.empty() || mesh.cell_ids.size() == mesh.kinds.size(), "array 'cell_ids'", "another size",
                "one for each cell");
}

}  // namespace

CellMesh receive_cell_mesh(const PackedFile& file) {
  MessageReader parcel(file, "neutral-cells");
  CellMesh mesh;
  mesh.points = parcel.rows<double, 3>("points");
  const Array<std::uint8_t> kinds = parcel.values<std::uint8_t>("kinds");
  parcel.expect(std::all_of(kinds.begin(), kinds.end(), is_known), "array 'kinds'", "a kind of cell that is not known",
                "one of CellKind");
  mesh.kinds.resize(kinds.size());
  std::transform(kinds.begin(), kinds.end(), mesh.kinds.begin(),
                 [](std::uint8_t kind) { return static_cast<CellKind>(kind); });
  mesh.cell_offsets = parcel.values<std::uint64_t>("cell_offsets");
  mesh.cell_nodes = parcel.values<std::uint64_t>("cell_nodes");
  mesh.cell_ids = parcel.values<std::uint64_t>("cell_ids");
  check_cells(parcel, mesh);
  mesh.length_unit = parcel.next_text();
  mesh.point_fields = take_fields(file, parcel, "point_fields", mesh.points.size());
  mesh.cell_fields = take_fields(file, parcel, "cell_fields", mesh.kinds.size());
  mesh.notes = parcel.remaining_texts();
  return mesh;
}

void send(const NeutralMesh& mesh, int descriptor) {
  MessageWriter parcel;
  parcel.add("points", mesh.points);
  parcel.add("cells", mesh.cells);
  parcel.add("cell_ids", mesh.cell_ids);
  Array<std::array<std::uint64_t, 2>> point_facts, cell_facts;
  std::vector<std::string> texts{mesh.length_unit};
  add_fields(parcel, "point_fields", mesh.point_fields, point_facts, texts);
  add_fields(parcel, "cell_fields", mesh.cell_fields, cell_facts, texts);
  texts.insert(texts.end(), mesh.notes.begin(), mesh.notes.end());
  parcel.add_texts(texts);
  parcel.write("neutral-mesh", descriptor);
}

NeutralMesh receive_mesh(const PackedFile& file) {
  MessageReader parcel(file, "neutral-mesh");
  NeutralMesh mesh;
  mesh.points = parcel.rows<double, 3>("points");
  mesh.cells = parcel.rows<std::uint64_t, 4>("cells");
  mesh.cell_ids = parcel.values<std::uint64_t>("cell_ids");
  parcel.expect(mesh.cell_ids.empty() || mesh.cell_ids.size() == mesh.cells.size(), "array 'cell_ids'", "another size",
                "one for each cell");
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    for (const std::uint64_t vertex : mesh.cells[cell])
      if (vertex >= mesh.points.size())
        formats::refuse(file.name(), concat("array 'cells', cell ", cell), concat("point ", vertex),
                        concat("a number below ", mesh.points.size()));
  mesh.length_unit = parcel.next_text();
  mesh.point_fields = take_fields(file, parcel, "point_fields", mesh.points.size());
  mesh.cell_fields = take_fields(file, parcel, "cell_fields", mesh.cells.size());
  mesh.notes = parcel.remaining_texts();
  return mesh;
}

void send(const NeutralSurface& surface, int descriptor) {
  MessageWriter parcel;
  parcel.add("points", surface.points);
  parcel.add("point_sizes", surface.point_sizes);
  parcel.add("facet_offsets", surface.facet_offsets);
  parcel.add("facet_corners", surface.facet_corners);
  parcel.add("facet_faces", surface.facet_faces);
  parcel.add("holes", surface.holes);
  Array<std::array<double, 5>> regions;
  for (const NeutralSurface::Region& region : surface.regions)
    regions.push_back({region.seed[0], region.seed[1], region.seed[2], region.attribute, region.max_volume});
  parcel.add("regions", regions);
  Array<std::uint64_t> opening_faces;
  Array<std::array<double, 3>> opening_seeds;
  for (const NeutralSurface::Opening& opening : surface.openings) {
    opening_faces.push_back(opening.face);
    opening_seeds.push_back(opening.seed);
  }
  parcel.add("opening_faces", opening_faces);
  parcel.add("opening_seeds", opening_seeds);
  parcel.add_texts(surface.notes);
  parcel.write("neutral-surface", descriptor);
}

namespace {

void check_facets(const MessageReader& parcel, const NeutralSurface& surface) {
  const Array<std::uint64_t>& offsets = surface.facet_offsets;
  parcel.expect(!offsets.empty() && offsets.front() == 0 && offsets.back() == surface.facet_corners.size() &&
                    std::is_sorted(offsets.begin(), offsets.end()),
                "array 'facet_offsets'", "offsets that do not fit", "rising from 0 to the number of corners");
  parcel.expect(std::all_of(surface.facet_corners.begin(), surface.facet_corners.end(),
                            [&](std::uint64_t corner) { return corner < surface.points.size(); }),
                "array 'facet_corners'", "a point that is not there", "positions below the number of points");
  parcel.expect(surface.point_sizes.empty() || surface.point_sizes.size() == surface.points.size(),
                "array 'point_sizes'", "another size", "one for each point");
}

void check_faces(const MessageReader& parcel, const NeutralSurface& surface) {
  const Array<std::uint64_t>& faces = surface.facet_faces;
  parcel.expect(faces.empty() || faces.size() + 1 == surface.facet_offsets.size(), "array 'facet_faces'",
                "another size", "one for each facet");
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const std::uint64_t before = i == 0 ? 0 : faces[i - 1];
    parcel.expect(faces[i] == before || (i > 0 && faces[i] == before + 1), "array 'facet_faces'", "a jump",
                  "0, 1, 2, ...");
  }
  for (const NeutralSurface::Opening& opening : surface.openings)
    parcel.expect(!faces.empty() && opening.face <= faces.back(), "array 'opening_faces'", "a face that is not there",
                  "a number of facet_faces");
}

}  // namespace

NeutralSurface receive_surface(const PackedFile& file) {
  MessageReader parcel(file, "neutral-surface");
  NeutralSurface surface;
  surface.points = parcel.rows<double, 3>("points");
  surface.point_sizes = parcel.values<double>("point_sizes");
  surface.facet_offsets = parcel.values<std::uint64_t>("facet_offsets");
  surface.facet_corners = parcel.values<std::uint64_t>("facet_corners");
  surface.facet_faces = parcel.values<std::uint64_t>("facet_faces");
  surface.holes = parcel.rows<double, 3>("holes");
  for (const auto& [x, y, z, attribute, max_volume] : parcel.rows<double, 5>("regions"))
    surface.regions.push_back({{x, y, z}, attribute, max_volume});
  const Array<std::uint64_t> opening_faces = parcel.values<std::uint64_t>("opening_faces");
  const auto opening_seeds = parcel.rows<double, 3>("opening_seeds");
  parcel.expect(opening_faces.size() == opening_seeds.size(), "array 'opening_faces'", "another size",
                "one for each seed");
  for (std::size_t i = 0; i < opening_faces.size(); ++i)
    surface.openings.push_back({opening_faces[i], opening_seeds[i]});
  surface.notes = parcel.remaining_texts();
  check_facets(parcel, surface);
  check_faces(parcel, surface);
  return surface;
}

}  // namespace rhoray::preprocess
