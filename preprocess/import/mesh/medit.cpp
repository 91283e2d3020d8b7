// Medit's meshes: .mesh (text), .meshb (binary), and a .sol or .solb beside them with values at the
// vertices. Source: Frey, "MEDIT: An interactive mesh visualization software", INRIA RT-0253; for
// the binary form and its section numbers, libMeshb (libmeshb7.h and its manual).

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// A section: its keyword in the text form, and its number in the binary form.
struct Section {
  std::string_view word;
  std::int32_t number;
};
constexpr Section known_sections[] = {{"Dimension", 3},
                                      {"Vertices", 4},
                                      {"Edges", 5},
                                      {"Triangles", 6},
                                      {"Quadrilaterals", 7},
                                      {"Tetrahedra", 8},
                                      {"Prisms", 9},
                                      {"Pentahedra", 9},
                                      {"Hexahedra", 10},
                                      {"TetrahedraP2", 30},
                                      {"HexahedraQ2", 33},
                                      {"Polyhedra", 46},
                                      {"Pyramids", 49},
                                      {"End", 54},
                                      {"SolAtVertices", 62},
                                      {"SolAtEdges", 63},
                                      {"SolAtTriangles", 64},
                                      {"SolAtQuadrilaterals", 65},
                                      {"SolAtTetrahedra", 66},
                                      {"SolAtPrisms", 67},
                                      {"SolAtHexahedra", 68},
                                      {"PrismsP2", 86},
                                      {"PyramidsP2", 87},
                                      {"TetrahedraP3", 96},
                                      {"TetrahedraP4", 97},
                                      {"HexahedraQ3", 98},
                                      {"HexahedraQ4", 99},
                                      {"PyramidsP3", 100},
                                      {"PyramidsP4", 101},
                                      {"PrismsP3", 102},
                                      {"PrismsP4", 103}};

/// A section of cells, faces or lines: nodes per cell, and VTK's kind.
struct CellSection {
  std::uint64_t node_count;
  std::uint8_t kind;
};
const std::map<std::string_view, CellSection> cell_sections{
    {"Edges", {2, 3}},      {"Triangles", {3, 5}}, {"Quadrilaterals", {4, 9}}, {"Tetrahedra", {4, 10}},
    {"Hexahedra", {8, 12}}, {"Prisms", {6, 13}},   {"Pentahedra", {6, 13}},    {"Pyramids", {5, 14}}};

/// A file as sections of numbers, in either form.
class MeditFile {
 public:
  explicit MeditFile(const std::filesystem::path& path) : path_(path), file_(path), in_(file_) {
    if (extension_of(path).ends_with('b'))
      in_.begin_binary();
    else if (const std::string_view word = words_.word("MeshVersionFormatted"); word != "MeshVersionFormatted")
      words_.refuse(word, "MeshVersionFormatted");
    version_ = small("a version");
    if (version_ < 1 || version_ > 4) words_.refuse(concat(version_), "a version, 1 to 4", ErrorCode::unsupported);
  }

  /// Moves to the next known section, skipping unread content of the last one, and returns its
  /// keyword; empty at "End".
  std::string_view next_section() { return in_.is_binary ? next_binary_section() : next_text_section(); }

  std::uint64_t count(std::string_view expected) {
    const std::int64_t value = integer(expected);
    if (value < 0) words_.refuse(concat(value), expected);
    return static_cast<std::uint64_t>(value);
  }
  std::int64_t integer(std::string_view expected) {
    return version_ == 4 || !in_.is_binary ? in_.next<std::int64_t>(expected) : small(expected);
  }
  /// A number stored like those of the header, whatever the version.
  std::int32_t small(std::string_view expected) { return in_.next<std::int32_t>(expected); }
  double real(std::string_view expected) {
    const bool is_float = in_.is_binary && version_ == 1;
    return is_float ? static_cast<double>(in_.next<float>(expected)) : in_.next<double>(expected);
  }

  /// Call it if the numbers of this section are not read.
  void pass_over() { section_ = {}; }

  /// Notes of text sections with more numbers than their records have.
  const std::vector<std::string>& notes() const { return notes_; }

  bool is_single_precision() const { return version_ == 1; }
  const std::filesystem::path& path() const { return path_; }
  [[noreturn]] void refuse(std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const {
    words_.refuse(found, expected, error_code);
  }

 private:
  /// The keyword of the first known section of which this is true; empty when there is none.
  template <class Is>
  static std::string_view known_word(const Is& is) {
    const auto* found = std::find_if(std::begin(known_sections), std::end(known_sections), is);
    return found == std::end(known_sections) ? std::string_view() : found->word;
  }

  std::string_view next_text_section() {
    for (;;) {
      const std::string_view word = words_.word("End");
      if (word.starts_with('#')) {
        words_.line();
        continue;
      }
      if (std::isalpha(static_cast<unsigned char>(word.front())) == 0) {
        ++rest_;
        continue;
      }
      note_rest();
      if (word == "End") return {};
      section_ = known_word([&](const Section& section) { return section.word == word; });
      if (!section_.empty()) return section_;
    }
  }

  void note_rest() {
    if (rest_ > 0 && !section_.empty())
      notes_.push_back(concat(path_.filename().string(), ": section ", section_, ": ",
                              count_text(rest_, "number", "numbers"), " after its records ",
                              rest_ == 1 ? "was" : "were", " left out"));
    rest_ = 0;
  }

  /// Each section begins with its number and the position of the next one.
  std::string_view next_binary_section() {
    for (;;) {
      if (next_ != 0) {
        if (next_ < words_.position()) words_.refuse(concat("a section at byte ", next_), "one behind the last");
        words_.bytes(next_ - words_.position(), "sections");
      }
      const std::int32_t number = small("a section");
      if (number == 54) return {};
      const std::int64_t next = version_ >= 3 ? in_.next<std::int64_t>("a place") : small("a place");
      if (next <= 0) words_.refuse(concat("the next section at byte ", next), "a place in the file");
      next_ = static_cast<std::uint64_t>(next);
      const std::string_view known = known_word([&](const Section& section) { return section.number == number; });
      if (!known.empty()) return known;
    }
  }

  std::filesystem::path path_;
  ForeignFile file_;
  NumberReader in_;
  WordReader& words_ = in_.words;
  std::int32_t version_ = 0;
  std::uint64_t next_ = 0;
  std::string_view section_;  ///< the last one; empty if its numbers are passed over
  std::uint64_t rest_ = 0;    ///< numbers after its records
  std::vector<std::string> notes_;
};

void append(std::vector<std::string>& notes, const std::vector<std::string>& more) {
  notes.insert(notes.end(), more.begin(), more.end());
}

void check_dimension(MeditFile& file) {
  const std::int32_t dimension = file.small("3: the dimension");
  if (dimension != 3) file.refuse(concat(dimension, " dimensions"), "3", ErrorCode::unsupported);
}

class MeditReader {
 public:
  explicit MeditReader(const std::filesystem::path& path) : file_(path) {}

  CellMesh read() {
    for (std::string_view word = file_.next_section(); !word.empty(); word = file_.next_section()) {
      const auto cells = cell_sections.find(word);
      if (word == "Dimension")
        check_dimension(file_);
      else if (word == "Vertices")
        read_vertices();
      else if (cells != cell_sections.end())
        read_cells(cells->second);
      else if (word.starts_with("SolAt"))
        file_.pass_over();
      else
        file_.refuse(concat("section ", word), "Tetrahedra, Hexahedra, Prisms or Pyramids", ErrorCode::unsupported);
    }
    append(mesh_.notes, file_.notes());
    mesh_.cell_fields.push_back(field_of("reference", std::move(references_)));
    read_solutions();
    take_cells(mesh_, std::move(cells_), file_.path());
    return std::move(mesh_);
  }

 private:
  void read_vertices() {
    const std::uint64_t total = file_.count("a number of vertices");
    for (std::uint64_t i = 0; i < total; ++i) {
      for (double& coordinate : mesh_.points.emplace_back()) coordinate = file_.real("three coordinates");
      file_.integer("a reference");
    }
  }

  void read_cells(const CellSection& section) {
    const std::uint64_t total = file_.count("a number of cells");
    for (std::uint64_t i = 0; i < total; ++i) {
      // counts from 1; a 0 wraps to a huge number and is refused
      for (std::uint64_t k = 0; k < section.node_count; ++k)
        cells_.nodes.push_back(static_cast<std::uint64_t>(file_.integer("a vertex") - 1));
      cells_.offsets.push_back(cells_.nodes.size());
      cells_.kinds.push_back(section.kind);
      references_.push_back(static_cast<double>(file_.integer("a reference")));
    }
  }

  void read_solutions() {
    for (const char* extension : {".sol", ".solb"}) {
      const auto beside = std::filesystem::path(file_.path()).replace_extension(extension);
      if (!is_there(beside)) continue;
      MeditFile file(beside);
      for (std::string_view word = file.next_section(); !word.empty(); word = file.next_section()) {
        if (word == "Dimension") {
          check_dimension(file);
        } else if (word == "SolAtVertices") {
          read_solution(file);
        } else {
          file.pass_over();
          mesh_.notes.push_back(
              concat(beside.filename().string(), ": section ", word, " left out: only values at vertices are read"));
        }
      }
      append(mesh_.notes, file.notes());
    }
  }

  void read_solution(MeditFile& file) {
    if (const std::uint64_t count = file.count("a number of vertices"); count != mesh_.points.size())
      file.refuse(concat("values for ", count, " vertices"), concat(mesh_.points.size(), ", as the mesh has"));
    const std::int32_t field_count = file.small("a number of fields");
    if (field_count < 1 || field_count > 1000) file.refuse(concat(field_count, " fields"), "1 to 1000");
    std::vector<NeutralField> fields(static_cast<std::size_t>(field_count));
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const std::int32_t type = file.small("1 to 4: scalars, vectors, symmetric or full matrices");
      constexpr int widths[] = {1, 3, 6, 9};
      if (type < 1 || type > 4) file.refuse(concat("fields of type ", type), "1 to 4");
      fields[f].component_count = widths[type - 1];
      fields[f].name = fields.size() == 1 ? "solution" : concat("solution_", f + 1);
    }
    for (std::size_t i = 0; i < mesh_.points.size(); ++i)
      for (NeutralField& field : fields)
        for (int c = 0; c < field.component_count; ++c) field.values.push_back(file.real("a value"));
    for (NeutralField& field : fields) {
      if (field.component_count == 6) bring_to_our_order(field.values);
      field.was_single_precision = file.is_single_precision() || fits_single_precision(field.values);
      mesh_.point_fields.push_back(std::move(field));
    }
  }

  /// The file has the lower triangles of symmetric matrices, row by row (components.h has ours).
  static void bring_to_our_order(Array<double>& values) {
    for (std::size_t i = 0; i + 6 <= values.size(); i += 6) {
      const std::array<double, 6> m{values[i],     values[i + 2], values[i + 5],
                                    values[i + 1], values[i + 4], values[i + 3]};
      std::copy(m.begin(), m.end(), values.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  MeditFile file_;
  CellMesh mesh_;
  ForeignCells cells_{.kinds = {}, .offsets = {0}, .nodes = {}};
  Array<double> references_;
};

}  // namespace

CellMesh read_medit(const std::filesystem::path& path) {
  return MeditReader(path).read();
}

}  // namespace rhoray::preprocess
