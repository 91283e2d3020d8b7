#include "preprocess/workers/tetgen/fill.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/library_text.h"
#include "preprocess/workers/tetgen/enclosed_regions.h"
#include "preprocess/workers/tetgen/job.h"
#include "preprocess/workers/tetgen/sizes.h"

// libtet 1.5.0 calls the weak function terminatetetgen(), which frees the mesh and throws; the
// destructor that unwinding runs then frees it again. A definition that only throws, in the file
// that calls TetGen, takes its place. tetgen.h also leaks a macro REAL: it is included nowhere
// else.
#define terminatetetgen rhoray_unused_terminatetetgen
#include <tetgen.h>
#undef terminatetetgen
#undef REAL
[[gnu::visibility("default")]] void terminatetetgen(tetgenmesh*, int code);
void terminatetetgen(tetgenmesh*, int code) {
  throw code;
}

namespace rhoray::preprocess {

namespace {

/// While it lives, a crash ends the process by its signal, also under the sanitizers: the parent
/// expects crashes of TetGen, which is not compiled for them.
class CrashesBySignal {
 public:
  CrashesBySignal() {
    struct sigaction by_default {};
    by_default.sa_handler = SIG_DFL;
    sigaction(SIGSEGV, &by_default, &before_);
  }
  CrashesBySignal(const CrashesBySignal&) = delete;
  CrashesBySignal& operator=(const CrashesBySignal&) = delete;
  ~CrashesBySignal() { sigaction(SIGSEGV, &before_, nullptr); }

 private:
  struct sigaction before_ {};
};

/// Catches what TetGen prints on standard output while it lives.
class PrintedText {
 public:
  PrintedText() : memory_(memfd_create("tetgen-says", MFD_CLOEXEC)) {
    std::fflush(stdout);
    standard_output_ = dup(STDOUT_FILENO);
    if (memory_ < 0 || standard_output_ < 0 || dup2(memory_, STDOUT_FILENO) < 0)
      throw Error(ErrorCode::resource, "filling a surface: no descriptor for TetGen's messages");
  }
  PrintedText(const PrintedText&) = delete;
  PrintedText& operator=(const PrintedText&) = delete;
  ~PrintedText() {
    std::fflush(stdout);
    dup2(standard_output_, STDOUT_FILENO);
    close(standard_output_);
    close(memory_);
  }

  std::string so_far() const {
    std::fflush(stdout);
    std::string text;
    char block[4096];
    for (ssize_t got; (got = pread(memory_, block, sizeof block, static_cast<off_t>(text.size()))) > 0;)
      text.append(block, static_cast<std::size_t>(got));
    return text;
  }

 private:
  int memory_;
  int standard_output_ = -1;
};

void give_points(const NeutralSurface& surface, bool with_sizes, tetgenio& in) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(surface.points.size());
  in.pointlist = new double[3 * surface.points.size()];
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    std::copy(surface.points[i].begin(), surface.points[i].end(), in.pointlist + 3 * i);
  if (!with_sizes) return;
  in.numberofpointmtrs = 1;
  in.pointmtrlist = new double[surface.points.size()];
  std::copy(surface.point_sizes.begin(), surface.point_sizes.end(), in.pointmtrlist);
}

tetgenio::polygon ring_of(const NeutralSurface& surface, std::size_t facet) {
  const std::size_t first = surface.facet_offsets[facet], size = surface.facet_offsets[facet + 1] - first;
  tetgenio::polygon ring{.vertexlist = new int[size], .numberofvertices = static_cast<int>(size)};
  for (std::size_t i = 0; i < size; ++i) ring.vertexlist[i] = static_cast<int>(surface.facet_corners[first + i]);
  return ring;
}

/// One TetGen facet for each face: all rings with its number, and the openings in it.
void give_facets(const NeutralSurface& surface, tetgenio& in) {
  const std::size_t ring_count = surface.facet_offsets.size() - 1;
  const auto face_of = [&](std::size_t facet) {
    return surface.facet_faces.empty() ? facet : surface.facet_faces[facet];
  };
  in.facetlist = new tetgenio::facet[ring_count];
  for (std::size_t first = 0, next; first < ring_count; first = next) {
    next = first + 1;
    while (next < ring_count && face_of(next) == face_of(first)) ++next;
    tetgenio::facet& face = in.facetlist[in.numberoffacets++];
    tetgenio::init(&face);
    face.polygonlist = new tetgenio::polygon[next - first];
    for (std::size_t facet = first; facet < next; ++facet)
      face.polygonlist[face.numberofpolygons++] = ring_of(surface, facet);

    Array<double> openings;
    for (const auto& opening : surface.openings)
      if (opening.face == face_of(first)) openings.insert(openings.end(), opening.seed.begin(), opening.seed.end());
    if (openings.empty()) continue;
    face.numberofholes = static_cast<int>(openings.size() / 3);
    face.holelist = new double[openings.size()];
    std::copy(openings.begin(), openings.end(), face.holelist);
  }
}

/// Regions are numbered 1, 2, ... for TetGen, which makes up numbers for the other regions; the
/// wanted attributes come back in `region_field`.
void give_seeds(const NeutralSurface& surface, tetgenio& in) {
  if (!surface.holes.empty()) {
    in.numberofholes = static_cast<int>(surface.holes.size());
    in.holelist = new double[3 * surface.holes.size()];
    for (std::size_t i = 0; i < surface.holes.size(); ++i)
      std::copy(surface.holes[i].begin(), surface.holes[i].end(), in.holelist + 3 * i);
  }
  if (!surface.regions.empty()) {
    in.numberofregions = static_cast<int>(surface.regions.size());
    in.regionlist = new double[5 * surface.regions.size()];
    for (std::size_t i = 0; i < surface.regions.size(); ++i) {
      const NeutralSurface::Region& region = surface.regions[i];
      double* entry = std::copy(region.seed.begin(), region.seed.end(), in.regionlist + 5 * i);
      entry[0] = static_cast<double>(i + 1);
      entry[1] = region.max_volume > 0 ? region.max_volume : -1;
    }
  }
}

/// The first few facets that TetGen names in its complaint, each with its centre. It writes "#12"
/// for the twelfth face.
std::string named_facets(const NeutralSurface& surface, std::string_view printed) {
  const std::size_t ring_count = surface.facet_offsets.size() - 1;
  std::set<std::size_t> faces;
  for (std::size_t at = printed.find('#'); at != std::string_view::npos; at = printed.find('#', at + 1)) {
    std::size_t number = 0;
    const char* first = printed.data() + at + 1;
    if (std::from_chars(first, printed.data() + printed.size(), number).ec != std::errc{}) continue;
    if (number >= 1 && number <= ring_count) faces.insert(number - 1);
  }
  constexpr std::size_t most = 6;
  std::size_t named = 0;
  std::string names;
  for (const std::size_t face : faces) {
    if (named++ == most) return names + ", ...";
    const auto ring =
        surface.facet_faces.empty()
            ? face
            : static_cast<std::size_t>(std::lower_bound(surface.facet_faces.begin(), surface.facet_faces.end(), face) -
                                       surface.facet_faces.begin());
    if (ring >= ring_count) continue;
    const std::size_t first = surface.facet_offsets[ring], last = surface.facet_offsets[ring + 1];
    std::array<double, 3> centre{};
    for (std::size_t i = first; i < last; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        centre[axis] += surface.points[surface.facet_corners[i]][axis] / static_cast<double>(last - first);
    names += concat(names.empty() ? ": facet " : ", facet ", ring, " around (", centre[0], ", ", centre[1], ", ",
                    centre[2], ")");
  }
  return names;
}

[[noreturn]] void refuse(int code, const std::string& facets) {
  switch (code) {
    case 1:
      throw Error(ErrorCode::resource, "TetGen ran out of memory while filling the surface",
                  "allow more memory, or ask for larger tetrahedra");
    case 3:
      throw Error(ErrorCode::invalid, concat("surface: TetGen found facets that intersect", facets),
                  "repair the surface at this place");
    case 4:
      throw Error(ErrorCode::invalid, concat("surface: TetGen found a feature too small to resolve", facets),
                  "merge points that nearly coincide");
    case 5:
      throw Error(ErrorCode::invalid, concat("surface: TetGen found two facets that nearly touch", facets),
                  "move them apart, or merge them");
    case 10:
      throw Error(ErrorCode::invalid, concat("surface: TetGen refused the points and facets as given", facets),
                  "look for points that nearly coincide or nearly lie in one plane");
    default:
      throw Error(ErrorCode::invalid,
                  concat("surface: TetGen could not fill it and gave up with its internal error ", code, facets),
                  "try --quality 0, or a surface with better shaped triangles");
  }
}

/// TetGen calls this criterion for each tetrahedron. It takes a plain function, so a static pointer
/// holds the criterion.
class SizeCriterion {
 public:
  explicit SizeCriterion(SizeAt size_at) : size_at_(std::move(size_at)) { current_ = this; }
  SizeCriterion(const SizeCriterion&) = delete;
  SizeCriterion& operator=(const SizeCriterion&) = delete;
  ~SizeCriterion() { current_ = nullptr; }

  static bool is_too_large(double* a, double* b, double* c, double* d, double*, double) {
    return current_->judge({a, b, c, d});
  }

  void refuse_if_useless() const {
    if (bad_)
      throw Error(ErrorCode::invalid,
                  concat("size field: found an edge length of ", bad_->second, " at (", bad_->first[0], ", ",
                         bad_->first[1], ", ", bad_->first[2], "); expected one above 0"));
    if (!answered_)
      throw Error(ErrorCode::invalid, "size field: has no value anywhere in the surface",
                  "check that both use the same position and unit");
  }

 private:
  /// Refinement leaves edges between about half the longest that is allowed and that length: with
  /// this factor half of them are shorter than wanted.
  static constexpr double allowed = 1.6;

  bool judge(const std::array<const double*, 4>& corners) {
    double longest = 0;
    std::array<double, 3> centre{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] += corners[i][axis] / 4;
      for (std::size_t j = i + 1; j < 4; ++j)
        longest = std::max(longest, std::hypot(corners[i][0] - corners[j][0], corners[i][1] - corners[j][1],
                                               corners[i][2] - corners[j][2]));
    }
    if (is_longer(longest, centre)) return true;
    return std::any_of(corners.begin(), corners.end(), [&](const double* p) {
      return is_longer(longest, {p[0], p[1], p[2]});
    });
  }

  bool is_longer(double longest, const std::array<double, 3>& p) {
    const std::optional<double> wanted = size_at_(p);
    if (!wanted) return false;
    answered_ = true;
    if (!(*wanted > 0)) {
      if (!bad_) bad_ = {p, *wanted};
      return false;
    }
    return longest > allowed * *wanted;
  }

  static inline SizeCriterion* current_ = nullptr;
  SizeAt size_at_;
  bool answered_ = false;
  std::optional<std::pair<std::array<double, 3>, double>> bad_;
};

/// What a run of TetGen is given beside the surface.
struct Run {
  std::string switches;
  bool with_point_sizes = false;
  bool with_seeds = false;
  bool with_judge = false;
};

/// Runs TetGen once; what it prints stays inside.
void run_tetgen(const NeutralSurface& surface, const Run& wanted, tetgenio& out) {
  const PrintedText printed;
  const CrashesBySignal crashes_by_signal;
  const auto run = [&](std::string text, tetgenio& result) {
    tetgenio in;
    give_points(surface, wanted.with_point_sizes, in);
    give_facets(surface, in);
    if (wanted.with_seeds) give_seeds(surface, in);
    if (wanted.with_judge) in.tetunsuitable = SizeCriterion::is_too_large;
    ::tetrahedralize(text.data(), &in, &result);
  };
  int code = 0;
  try {
    run(wanted.switches, out);
  } catch (const int reported) {
    code = reported;
  } catch (const std::bad_alloc&) {
    code = 1;
  }
  if (code == 0) return;
  std::string facets = named_facets(surface, printed.so_far());
  if (code == 3 && facets.empty()) {  // its search for crossings names them all
    try {
      tetgenio ignored;
      run("d", ignored);
    } catch (const int) {
    }
    facets = named_facets(surface, printed.so_far());
  }
  note_library_text(printed.so_far());
  refuse(code, facets);
}

void check_filled(const tetgenio& out) {
  if (out.numberoftetrahedra == 0)
    throw Error(ErrorCode::invalid, "surface: encloses nothing; TetGen made no tetrahedra", "close the surface");
}

double determinant(const std::array<double, 3>& p, const double* a, const double* b, const double* c) {
  const auto edge = [&](const double* q, std::size_t axis) { return q[axis] - p[axis]; };
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    sum += edge(a, i) * (edge(b, j) * edge(c, k) - edge(b, k) * edge(c, j));
  }
  return sum;
}

/// The number of the region in which the point lies, or nothing outside of all.
std::optional<double> region_at(const tetgenio& mesh, const std::array<double, 3>& p) {
  for (int cell = 0; cell < mesh.numberoftetrahedra; ++cell) {
    const int* c = mesh.tetrahedronlist + std::ptrdiff_t{cell} * mesh.numberofcorners;
    const auto corner = [&](std::size_t i) { return mesh.pointlist + 3 * std::ptrdiff_t{c[i]}; };
    const std::array<double, 4> parts{
        determinant(p, corner(1), corner(2), corner(3)), -determinant(p, corner(0), corner(2), corner(3)),
        determinant(p, corner(0), corner(1), corner(3)), -determinant(p, corner(0), corner(1), corner(2))};
    const auto [least, most] = std::minmax_element(parts.begin(), parts.end());
    if (*least >= -1e-12 * *most || *most <= 1e-12 * *least) return mesh.tetrahedronattributelist[cell];
  }
  return std::nullopt;
}

/// TetGen 1.5.0 crashes on a seed that lies outside and drops all seeds of a region but one: a
/// first filling, with neither seeds nor new points, tells where they lie.
void check_seeds(const NeutralSurface& surface) {
  tetgenio enclosed_regions;
  run_tetgen(surface, {.switches = "pA"}, enclosed_regions);
  check_filled(enclosed_regions);
  const auto refuse_seed = [](std::string_view kind, std::size_t number, const std::array<double, 3>& seed,
                              std::string_view why) {
    throw Error(
        ErrorCode::invalid,
        concat("surface: the seed of ", kind, " ", number, ", (", seed[0], ", ", seed[1], ", ", seed[2], "), ", why),
        "each region takes one seed, inside the surface");
  };
  std::set<double> taken;
  for (std::size_t i = 0; i < surface.holes.size(); ++i)
    if (!region_at(enclosed_regions, surface.holes[i]))
      refuse_seed("hole", i, surface.holes[i], "lies outside of every region");
  for (std::size_t i = 0; i < surface.regions.size(); ++i) {
    const auto enclosed = region_at(enclosed_regions, surface.regions[i].seed);
    if (!enclosed) refuse_seed("region", i, surface.regions[i].seed, "lies outside of every region");
    if (!taken.insert(*enclosed).second)
      refuse_seed("region", i, surface.regions[i].seed, "lies in a region that has a seed already");
  }
}

std::vector<EnclosedRegion> regions_in(const tetgenio& mesh) {
  const auto cells = static_cast<std::size_t>(mesh.numberoftetrahedra);
  const auto corners = static_cast<std::size_t>(mesh.numberofcorners);
  return regions_of({.coordinates = {mesh.pointlist, 3 * static_cast<std::size_t>(mesh.numberofpoints)},
                     .corners = {mesh.tetrahedronlist, cells * corners},
                     .corners_per_cell = corners,
                     .region = {mesh.tetrahedronattributelist, cells},
                     .neighbours = {mesh.neighborlist, 4 * cells}});
}

/// Seeds for all regions, so that each can have a limit of its own or be left empty. A first
/// filling without new points tells where they lie.
void seed_regions(NeutralSurface& surface, bool empty_cavities) {
  tetgenio filled;
  run_tetgen(surface, {.switches = "pAn"}, filled);
  check_filled(filled);
  for (const EnclosedRegion& enclosed : regions_in(filled)) {
    if (empty_cavities && enclosed.depth % 2 == 0)
      surface.holes.push_back(enclosed.seed);
    else
      surface.regions.push_back(
          {.seed = enclosed.seed, .attribute = static_cast<double>(surface.regions.size() + 1), .max_volume = 0});
  }
}

void limit_regions(NeutralSurface& surface, const std::vector<TetrahedralizeOptions::RegionVolume>& limits) {
  for (const auto& limit : limits) {
    bool found = false;
    std::string known;
    for (auto& region : surface.regions) {
      known += concat(known.empty() ? "" : " ", region.attribute);
      if (region.attribute != limit.region) continue;
      region.max_volume = limit.max_volume;
      found = true;
    }
    if (!found)
      throw Error(ErrorCode::usage,
                  concat("surface: has no region ", limit.region, " whose volume could be limited; it has ", known));
  }
}

/// TetGen's number of a region -> ours: the seeds' attributes, and on from the largest of them for
/// regions without a seed; without any seed 1, 2, ... from outside in.
std::map<double, double> region_numbers(const NeutralSurface& surface, const tetgenio& out) {
  std::map<double, double> numbers;
  double largest = 0;
  for (std::size_t i = 0; i < surface.regions.size(); ++i) {
    numbers[static_cast<double>(i + 1)] = surface.regions[i].attribute;
    largest = std::max(largest, std::floor(surface.regions[i].attribute));
  }
  for (const EnclosedRegion& enclosed : regions_in(out))
    if (numbers.try_emplace(enclosed.number, largest + 1).second) ++largest;
  return numbers;
}

NeutralField region_field(const NeutralSurface& surface, const tetgenio& out) {
  const std::map<double, double> numbers = region_numbers(surface, out);
  NeutralField field{.name = "region", .unit = {}, .component_count = 1, .was_single_precision = true, .values = {}};
  field.values.reserve(static_cast<std::size_t>(out.numberoftetrahedra));
  for (int cell = 0; cell < out.numberoftetrahedra; ++cell) {
    const double value = numbers.at(out.tetrahedronattributelist[cell]);
    field.was_single_precision = field.was_single_precision && static_cast<double>(static_cast<float>(value)) == value;
    field.values.push_back(value);
  }
  return field;
}

NeutralMesh mesh_of(const NeutralSurface& surface, const tetgenio& out) {
  NeutralMesh mesh;
  mesh.notes = surface.notes;
  mesh.points.resize(static_cast<std::size_t>(out.numberofpoints));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) std::copy_n(out.pointlist + 3 * i, 3, mesh.points[i].begin());
  mesh.cells.resize(static_cast<std::size_t>(out.numberoftetrahedra));
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    for (std::size_t i = 0; i < 4; ++i) {
      const int* corners = out.tetrahedronlist + cell * static_cast<std::size_t>(out.numberofcorners);
      mesh.cells[cell][i] = static_cast<std::uint64_t>(corners[i]);
    }
  if (out.numberoftetrahedronattributes > 0) {
    NeutralField field = region_field(surface, out);
    const bool one_region = std::all_of(field.values.begin(), field.values.end(),
                                        [&](double value) { return value == field.values.front(); });
    if (!surface.regions.empty() || !one_region) mesh.cell_fields.push_back(std::move(field));
  }
  return mesh;
}

}  // namespace

NeutralMesh fill(NeutralSurface surface, const TetrahedralizeOptions& options) {
  const bool has_seeds = !surface.holes.empty() || !surface.regions.empty();
  if (has_seeds)
    check_seeds(surface);
  else if (!options.region_volumes.empty() || options.empty_cavities)
    seed_regions(surface, options.empty_cavities);
  limit_regions(surface, options.region_volumes);

  std::optional<SizeCriterion> judge;
  if (options.size_field) judge.emplace(size_at(*options.size_field));
  tetgenio out;
  run_tetgen(surface,
             {.switches = tetgen_switches(options, surface),
              .with_point_sizes = options.use_point_sizes && !surface.point_sizes.empty(),
              .with_seeds = true,
              .with_judge = judge.has_value()},
             out);
  if (judge) judge->refuse_if_useless();
  check_filled(out);
  return mesh_of(surface, out);
}

}  // namespace rhoray::preprocess
