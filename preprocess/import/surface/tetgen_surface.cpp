#include "preprocess/import/mesh/tetgen_text.h"
#include "preprocess/import/reading/families.h"

namespace rhoray::preprocess {
namespace {

/// Words of a record that may span several lines: TetGen lets long polygons continue on the next
/// line.
class RecordWords {
 public:
  RecordWords(LineReader& lines, std::size_t next) : lines_(lines), next_(next) {}

  std::uint64_t corner(const TetgenPoints& points) {
    if (next_ == lines_.words().size()) {
      lines_.need("another corner");
      next_ = 0;
    }
    return tetgen_corner(lines_, next_++, points);
  }

 private:
  LineReader& lines_;
  std::size_t next_;
};

/// Reads one polygon: the number of corners, then the corners. The current line begins with the
/// number.
void read_polygon(LineReader& lines, const TetgenPoints& points, std::uint64_t fewest_corners,
                  NeutralSurface& surface) {
  const std::uint64_t corners = tetgen_count(lines, "a number of corners", RecordPlace::from_this_line);
  if (corners < fewest_corners)
    lines.refuse(concat("a polygon with ", corners, " corners"), concat("at least ", fewest_corners),
                 ErrorCode::unsupported);
  RecordWords words(lines, 1);
  for (std::uint64_t i = 0; i < corners; ++i) surface.facet_corners.push_back(words.corner(points));
  surface.facet_offsets.push_back(surface.facet_corners.size());
}

/// Part 2 of a .poly file: each facet is one or more polygons in a plane, and points in the
/// openings between them.
void read_poly_facets(LineReader& lines, const TetgenPoints& points, NeutralSurface& surface) {
  const std::uint64_t count = tetgen_count(lines, "a number of facets");
  bool simple = true;
  for (std::uint64_t face = 0; face < count; ++face) {
    lines.need(concat(count, " facets"));
    const std::uint64_t polygons = tetgen_count(lines, "a number of polygons");
    if (polygons == 0) lines.refuse("a facet without polygons", "at least 1");
    const std::uint64_t openings = lines.words().size() > 1 ? lines.number<std::uint64_t>(1, "a number of holes") : 0;
    simple = simple && polygons == 1 && openings == 0;
    for (std::uint64_t i = 0; i < polygons; ++i) {
      lines.need("a polygon");
      // segments and points may lie in a larger facet
      read_polygon(lines, points, polygons == 1 ? 3 : 1, surface);
      surface.facet_faces.push_back(face);
    }
    for (std::uint64_t i = 0; i < openings; ++i) {
      lines.need("a point in a hole of the facet");
      surface.openings.push_back({face, lines.point(1)});
    }
  }
  if (simple) surface.facet_faces.clear();
}

/// Part 2 of a .smesh file: each facet is one polygon.
void read_smesh_facets(LineReader& lines, const TetgenPoints& points, NeutralSurface& surface) {
  const std::uint64_t count = tetgen_count(lines, "a number of facets");
  for (std::uint64_t i = 0; i < count; ++i) {
    lines.need(concat(count, " facets"));
    read_polygon(lines, points, 3, surface);
  }
}

/// Parts 3 and 4, which may be missing: points in cavities, points in regions.
void read_holes_and_regions(LineReader& lines, NeutralSurface& surface) {
  if (!lines.next()) return;
  const std::uint64_t holes = tetgen_count(lines, "a number of holes");
  for (std::uint64_t i = 0; i < holes; ++i) {
    lines.need(concat(holes, " holes"));
    surface.holes.push_back(lines.point(1));
  }
  if (!lines.next()) return;
  const std::uint64_t regions = tetgen_count(lines, "a number of regions");
  for (std::uint64_t i = 0; i < regions; ++i) {
    lines.need(concat(regions, " regions"));
    NeutralSurface::Region& region = surface.regions.emplace_back();
    region.seed = lines.point(1);
    region.attribute = lines.number<double>(4, "a region's attribute");
    if (lines.words().size() > 5) region.max_volume = lines.number<double>(5, "a largest volume");
    if (!(region.max_volume > 0)) region.max_volume = 0;  // TetGen writes -1 for "no limit"
  }
}

/// Leaves out points that no face uses: they lie inside, and would disturb filling the surface.
NeutralSurface surface_of(const Array<std::array<std::uint64_t, 3>>& faces, const TetgenPoints& points) {
  constexpr std::uint64_t unused = ~std::uint64_t{0};
  Array<std::uint64_t> positions(points.points.size(), unused);
  for (const auto& face : faces)
    for (const std::uint64_t corner : face) positions[corner] = 0;
  NeutralSurface surface;
  for (std::uint64_t i = 0; i < positions.size(); ++i) {
    if (positions[i] == unused) continue;
    positions[i] = surface.points.size();
    surface.points.push_back(points.points[i]);
  }
  for (const auto& face : faces) {
    for (const std::uint64_t corner : face) surface.facet_corners.push_back(positions[corner]);
    surface.facet_offsets.push_back(surface.facet_corners.size());
  }
  if (const std::uint64_t inside = points.points.size() - surface.points.size(); inside > 0)
    surface.notes.push_back(concat(count_text(inside, "point", "points"), " that no face uses left out"));
  return surface;
}

}  // namespace

NeutralSurface read_tetgen_surface(const std::filesystem::path& path) {
  const ForeignFile file(path);
  LineReader lines(file);
  lines.need("a number of points");
  TetgenPoints points = read_tetgen_points(lines);
  if (points.points.empty()) points = read_tetgen_node_file(std::filesystem::path(path).replace_extension(".node"));
  NeutralSurface surface;
  surface.points = points.points;
  surface.notes = points.notes;
  lines.need("a number of facets");
  if (extension_of(path) == ".smesh")
    read_smesh_facets(lines, points, surface);
  else
    read_poly_facets(lines, points, surface);
  if (surface.facet_corners.empty()) lines.refuse("no facets", "at least 1");
  read_holes_and_regions(lines, surface);
  return surface;
}

NeutralSurface read_tetgen_faces(const std::filesystem::path& path) {
  const TetgenPoints points = read_tetgen_node_file(std::filesystem::path(path).replace_extension(".node"));
  const ForeignFile file(path);
  LineReader lines(file);
  lines.need("a number of faces");
  const std::uint64_t count = tetgen_count(lines, "a number of faces");
  const bool is_binary = is_tetgen_binary(lines);
  Array<std::array<std::uint64_t, 3>> faces;
  if (is_binary) {
    const bool has_marker = lines.words().size() > 2 && lines.number<int>(1, "0 or 1: markers") != 0;
    TetgenBinary records(lines, count, 3 * sizeof(std::uint32_t) + (has_marker ? sizeof(double) : 0));
    for (std::uint64_t i = 0; i < count; ++i) {
      for (std::uint64_t& corner : faces.emplace_back())
        corner = tetgen_corner(lines, records.next<std::uint32_t>(), points);
      if (has_marker) records.next<double>();
    }
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      lines.need(concat(count, " faces"));
      std::array<std::uint64_t, 3>& corners = faces.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) corners[k] = tetgen_corner(lines, 1 + k, points);
    }
  }
  if (faces.empty()) lines.refuse("no faces", "at least 1");
  NeutralSurface surface = surface_of(faces, points);
  surface.notes.insert(surface.notes.end(), points.notes.begin(), points.notes.end());
  if (!is_binary) lines.note_rest("faces", surface.notes);
  return surface;
}

Array<double> read_tetgen_sizes(const std::filesystem::path& path, std::size_t point_count) {
  const ForeignFile file(path);
  LineReader lines(file);
  lines.need("a number of points");
  const std::uint64_t count = tetgen_count(lines, "a number of points");
  if (count != point_count)
    lines.refuse(concat("sizes for ", count, " points"), concat(point_count, ", as the surface has"));
  if (lines.words().size() > 1 && lines.number<int>(1, "numbers for each point") != 1)
    lines.refuse(concat(lines.words()[1], " numbers for each point"), "1, an edge length", ErrorCode::unsupported);
  Array<double> sizes;
  for (std::uint64_t i = 0; i < count; ++i) {
    lines.need(concat(count, " sizes"));
    sizes.push_back(lines.number<double>(0, "an edge length"));
    if (!(sizes.back() > 0)) lines.refuse(lines.words()[0], "an edge length above 0");
  }
  return sizes;
}

}  // namespace rhoray::preprocess
