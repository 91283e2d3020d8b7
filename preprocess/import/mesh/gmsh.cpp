// Gmsh's own meshes, MSH 2 and 4.1, text and binary. Gmsh's library is not used: it ends the
// process on damaged files, and keeps only one of several elements with the same number.
// Source: Gmsh Reference Manual, "MSH file format" and "MSH file format version 2".

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "preprocess/import/mesh/gmsh_elements.h"
#include "preprocess/import/mesh/id_positions.h"
#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/label_names.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/reading/time_steps.h"

namespace rhoray::preprocess {
namespace {

/// The numbers of MSH files.
class MshNumbers : public NumberReader {
 public:
  using NumberReader::NumberReader;
  /// 8 bytes in MSH 4.1
  std::uint64_t count(std::string_view expected) { return next<std::uint64_t>(expected); }
  std::int32_t integer(std::string_view expected) { return next<std::int32_t>(expected); }
  double real(std::string_view expected) { return next<double>(expected); }
};

class MshReader {
 public:
  MshReader(const std::filesystem::path& path, const std::string& time)
      : path_(path), file_(path), in_(file_), time_(time) {}

  CellMesh read() {
    read_format();
    while (!in_.words.at_end()) read_section();
    connect();
    name_groups();
    read_fields();
    take_cells(mesh_, std::move(cells_), path_);
    return std::move(mesh_);
  }

 private:
  /// A time, and the number of earlier steps that a field has at the same time. Times that are NaN
  /// count as equal.
  struct Step {
    double time = 0;
    std::size_t rank = 0;

    bool has_time_of(const Step& other) const { return std::is_eq(std::weak_order(time, other.time)); }
    std::weak_ordering operator<=>(const Step& other) const {
      const std::weak_ordering order = std::weak_order(time, other.time);
      return std::is_eq(order) ? rank <=> other.rank : order;
    }
    bool operator==(const Step& other) const { return std::is_eq(*this <=> other); }
  };

  /// One $NodeData or $ElementData section: the values of a field at one time.
  struct Section {
    Step step;                 ///< its rank is counted when all sections are known
    std::uint64_t number = 0;  ///< of the step, as the file says it
    int component_count = 1;
    std::uint64_t count = 0;
    std::size_t position = 0;  ///< byte offset of the first value in the file
  };

  struct Field {
    std::string name;
    bool at_points = false;
    /// Several of one step are parts of it, as Gmsh writes them of partitioned meshes.
    std::vector<Section> sections;

    /// Orders the sections by their steps.
    void count_steps() {
      std::stable_sort(sections.begin(), sections.end(), [](const Section& a, const Section& b) {
        const std::weak_ordering order = std::weak_order(a.step.time, b.step.time);
        return std::is_eq(order) ? a.number < b.number : std::is_lt(order);
      });
      for (std::size_t i = 1; i < sections.size(); ++i) {
        const Section& last = sections[i - 1];
        if (last.step.has_time_of(sections[i].step))
          sections[i].step.rank = last.step.rank + (last.number != sections[i].number);
      }
    }

    /// Returns the sections of the chosen step. If the field has a single step, or a single step at
    /// the chosen time, returns the sections of that step.
    std::span<const Section> at(const Step& chosen) const {
      if (sections.front().step == sections.back().step) return sections;
      const std::span<const Section> then =
          between({chosen.time, 0}, {chosen.time, std::numeric_limits<std::size_t>::max()});
      return then.empty() || then.front().step == then.back().step ? then : between(chosen, chosen);
    }

    std::span<const Section> between(const Step& first, const Step& last) const {
      return {std::lower_bound(sections.begin(), sections.end(), first,
                               [](const Section& section, const Step& step) { return section.step < step; }),
              std::upper_bound(sections.begin(), sections.end(), last,
                               [](const Step& step, const Section& section) { return step < section.step; })};
    }
  };

  void read_format() {
    const std::string_view word = in_.words.word("$MeshFormat");
    const std::size_t begin = in_.words.position();
    if (word == "$NOD") in_.words.refuse(word, "$MeshFormat: this is MSH 1", ErrorCode::unsupported);
    if (word != "$MeshFormat") in_.words.refuse(word, "$MeshFormat");
    const std::string_view version = in_.words.word("a version");
    is_4_ = version == "4.1";
    if (!is_4_ && version != "2" && version != "2.0" && version != "2.1" && version != "2.2")
      in_.words.refuse(
          version, "MSH 2 to 2.2 or 4.1; Gmsh turns one into the other: gmsh OLD.msh -save -format msh41 -o NEW.msh",
          ErrorCode::unsupported);
    const int type = in_.words.number<int>("0 or 1: text or binary");
    if (type != 0 && type != 1) in_.words.refuse(concat(type), "0 or 1: text or binary");
    if (in_.words.number<int>("8: the size of numbers") != 8)
      in_.words.refuse("numbers of another size", "8 bytes each", ErrorCode::unsupported);
    in_.words.line();
    if (type == 1) in_.begin_binary();
    end_section("MeshFormat");
    remember("MeshFormat", begin);
  }

  void remember(const std::string& name, std::size_t begin) {
    sections_[name] = file_.text().substr(begin, in_.words.position() - begin);
  }

  /// Gmsh writes the whole mesh again before each view that it appends to a file. A section that
  /// repeats the same content is skipped; one with different content belongs to another mesh.
  bool is_repeated(const std::string& name) {
    const auto found = sections_.find(name);
    if (found == sections_.end()) return false;
    if (!file_.text().substr(in_.words.position()).starts_with(found->second))
      in_.words.refuse(concat("another section ", name), "the same one, or none: one mesh in a file",
                       ErrorCode::unsupported);
    in_.words.bytes(found->second.size(), name);
    return true;
  }

  void read_section() {
    const std::string_view word = in_.words.word("a section");
    if (!word.starts_with('$') || word.size() < 2) in_.words.refuse(word, "a section, $...");
    const std::string name(word.substr(1));
    if (is_repeated(name)) return;
    const std::size_t begin = in_.words.position();
    in_.words.line();
    if (name == "Nodes")
      is_4_ ? read_nodes_4() : read_nodes_2();
    else if (name == "Elements")
      is_4_ ? read_elements_4() : read_elements_2();
    else if ((name == "Entities" || name == "PartitionedEntities") && is_4_)
      read_entities(name != "Entities");
    else if (name == "PhysicalNames")
      read_names();
    else if (name == "NodeData" || name == "ElementData")
      return read_data_header(name);
    else
      return skip_section(name);
    end_section(name);
    remember(name, begin);
  }

  void end_section(const std::string& name) {
    const std::string_view word = in_.words.word(concat("$End", name));
    if (word != concat("$End", name)) in_.words.refuse(word, concat("$End", name));
  }

  /// Skips to the end of a section without reading its content.
  void skip_section(const std::string& name) {
    if (name == "ElementNodeData") left_out_.insert(name);
    const std::size_t begin = in_.words.position(), end = file_.text().find(concat("$End", name), begin);
    if (end == std::string_view::npos) in_.words.refuse("the end of the file", concat("$End", name));
    in_.words.bytes(end - begin, name);
    end_section(name);
  }

  void read_names() {
    for (auto left = in_.words.number<std::uint64_t>("a number of names"); left > 0; --left) {
      const int dimension = in_.words.number<int>("a dimension");
      const int group = in_.words.number<int>("a physical group");
      const std::string name = quoted();
      if (dimension == 3) names_.emplace_back(group, name);
    }
  }

  /// The rest of this line, without surrounding quotes.
  std::string quoted() {
    std::string_view text = in_.words.line();
    const std::size_t begin = text.find('"'), end = text.rfind('"');
    return std::string(begin == end ? text : text.substr(begin + 1, end - begin - 1));
  }

  void add_node(std::uint64_t id, const std::array<double, 3>& point) {
    node_ids_.push_back(id);
    mesh_.points.push_back(point);
  }

  std::array<double, 3> point() {
    std::array<double, 3> result;
    for (double& coordinate : result) coordinate = in_.real("three coordinates");
    return result;
  }

  void read_nodes_2() {
    const auto count = in_.words.number<std::uint64_t>("a number of nodes");
    if (in_.is_binary) in_.words.line();
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::int32_t id = in_.integer("a node's number");
      add_node(static_cast<std::uint64_t>(id), point());
    }
  }

  void read_nodes_4() {
    std::uint64_t blocks = in_.count("a number of blocks");
    const std::uint64_t total = in_.count("a number of nodes");
    in_.count("the smallest number of a node");
    in_.count("the largest number of a node");
    for (; blocks > 0; --blocks) {
      const std::int32_t dimension = in_.integer("an entity's dimension");
      in_.integer("an entity");
      const bool is_parametric = in_.integer("0 or 1: whether there are parameters") != 0;
      const std::uint64_t count = in_.count("a number of nodes");
      for (std::uint64_t i = 0; i < count; ++i) node_ids_.push_back(in_.count("a node's number"));
      for (std::uint64_t i = 0; i < count; ++i) {
        mesh_.points.push_back(point());
        for (std::int32_t k = 0; is_parametric && k < dimension; ++k) in_.real("a parameter");
      }
    }
    if (mesh_.points.size() != total) in_.words.refuse(concat(mesh_.points.size(), " nodes"), concat(total));
  }

  /// Passes over the number of partitions, and the entities that hold ghost cells.
  void read_partitions() {
    in_.count("a number of partitions");
    for (std::uint64_t ghosts = in_.count("a number of ghost entities"); ghosts > 0; --ghosts)
      for (const char* expected : {"a ghost entity", "its partition"}) in_.integer(expected);
  }

  /// Passes over the entity that was cut into partitions, and the numbers of these.
  void read_parent() {
    for (const char* expected : {"the parent's dimension", "the parent"}) in_.integer(expected);
    for (std::uint64_t left = in_.count("a number of partitions"); left > 0; --left) in_.integer("a partition");
  }

  /// Stores the first physical group of each volume. The parts of a volume repeat its groups.
  void read_entities(bool are_parts) {
    if (are_parts) read_partitions();
    std::array<std::uint64_t, 4> counts;
    for (std::uint64_t& count : counts) count = in_.count("numbers of points, curves, surfaces and volumes");
    for (std::size_t dimension = 0; dimension < 4; ++dimension)
      for (std::uint64_t left = counts[dimension]; left > 0; --left) {
        const std::int32_t entity = in_.integer("an entity");
        if (are_parts) read_parent();
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) in_.real("an entity's box");
        const std::uint64_t groups = in_.count("a number of physical groups");
        for (std::uint64_t k = 0; k < groups; ++k) {
          const std::int32_t group = in_.integer("a physical group");
          if (dimension != 3) continue;
          if (k == 0) groups_of_volumes_[entity] = group;
          if (k == 1 && !are_parts) ++volumes_in_several_groups_;
        }
        if (dimension == 0) continue;
        for (std::uint64_t bounding = in_.count("a number of bounding entities"); bounding > 0; --bounding)
          in_.integer("a bounding entity");
      }
  }

  const GmshElement& element_type(std::uint64_t number) {
    const auto [found, is_new] = types_.try_emplace(number);
    if (is_new) {
      const std::optional<GmshElement> type = gmsh_element(number);
      if (!type || !type->is_readable)
        in_.words.refuse(concat("elements of type ", number),
                         "tetrahedra or hexahedra of any order, wedges or pyramids of order 1 or 2, or what fills no "
                         "space",
                         ErrorCode::unsupported);
      found->second = *type;
    }
    return found->second;
  }

  /// Adds an element whose nodes come next; id_of_node reads one node.
  template <class IdOfNode>
  void add_element(const GmshElement& type, std::uint64_t id, std::int32_t physical, std::int32_t entity,
                   const IdOfNode& id_of_node) {
    element_ids_.push_back(id);
    physical_.push_back(physical);
    entity_.push_back(entity);
    const std::size_t first = cells_.nodes.size();
    given_.clear();
    for (std::uint64_t i = 0; i < type.node_count; ++i) given_.push_back(id_of_node());
    cells_.nodes.resize(first + type.node_count);
    for (std::uint64_t i = 0; i < type.node_count; ++i)
      cells_.nodes[first + i] = given_[type.order.empty() ? i : type.order[i]];
    cells_.offsets.push_back(cells_.nodes.size());
    cells_.kinds.push_back(type.kind);
  }

  void read_elements_2() {
    const auto total = in_.words.number<std::uint64_t>("a number of elements");
    if (in_.is_binary) in_.words.line();
    while (cells_.kinds.size() < total) {
      // In text each element has its own header; in binary one header precedes many elements.
      std::int32_t id = in_.is_binary ? 0 : in_.integer("an element's number");
      const GmshElement& type = element_type(static_cast<std::uint64_t>(in_.integer("an element's type")));
      const std::int32_t count = in_.is_binary ? in_.integer("a number of elements") : 1;
      const std::int32_t tags = in_.integer("a number of tags");
      if (count < 1 || tags < 0 || static_cast<std::uint64_t>(count) > total - cells_.kinds.size())
        in_.words.refuse(concat(count, " elements with ", tags, " tags"), "what is left, and at least no tags");
      for (std::int32_t i = 0; i < count; ++i) {
        if (in_.is_binary) id = in_.integer("an element's number");
        std::array<std::int32_t, 2> groups{};
        for (std::int32_t k = 0; k < tags; ++k) {
          const std::int32_t tag = in_.integer("a tag");
          if (k < 2) groups[static_cast<std::size_t>(k)] = tag;
        }
        add_element(type, static_cast<std::uint64_t>(id), groups[0], groups[1],
                    [&] { return static_cast<std::uint64_t>(in_.integer("a node's number")); });
      }
    }
  }

  void read_elements_4() {
    std::uint64_t blocks = in_.count("a number of blocks");
    const std::uint64_t total = in_.count("a number of elements");
    in_.count("the smallest number of an element");
    in_.count("the largest number of an element");
    for (; blocks > 0; --blocks) {
      const std::int32_t dimension = in_.integer("an entity's dimension");
      const std::int32_t entity = in_.integer("an entity");
      const GmshElement& type = element_type(static_cast<std::uint64_t>(in_.integer("an element's type")));
      const auto group = groups_of_volumes_.find(entity);
      const std::int32_t physical = dimension == 3 && group != groups_of_volumes_.end() ? group->second : 0;
      for (std::uint64_t left = in_.count("a number of elements"); left > 0; --left) {
        const std::uint64_t id = in_.count("an element's number");
        add_element(type, id, physical, entity, [&] { return in_.count("a node's number"); });
      }
    }
    if (cells_.kinds.size() != total) in_.words.refuse(concat(cells_.kinds.size(), " elements"), concat(total));
  }

  /// Reads the strings, real numbers and integers that describe a section of values. The values are
  /// read later, when the time step is chosen.
  void read_data_header(const std::string& section_name) {
    std::string name;
    Section section;
    auto count = in_.words.number<std::uint64_t>("a number of texts");
    in_.words.line();
    for (std::uint64_t k = 0; k < count; ++k) {
      const std::string text = quoted();
      if (k == 0) name = text;
    }
    if (name.empty()) name = section_name;
    count = in_.words.number<std::uint64_t>("a number of real numbers");
    for (std::uint64_t k = 0; k < count; ++k) {
      const double value = in_.words.number<double>("a real number");
      if (k == 0) section.step.time = value;
    }
    count = in_.words.number<std::uint64_t>("a number of integers");
    if (count < 3) in_.words.refuse(concat(count, " integers"), "at least 3: step, components, count");
    for (std::uint64_t k = 0; k < count; ++k) {
      const auto value = in_.words.number<std::uint64_t>("an integer");
      if (k == 0) section.number = value;
      if (k == 1 && (value < 1 || value > 9)) in_.words.refuse(concat(value, " components"), "1 to 9");
      if (k == 1) section.component_count = static_cast<int>(value);
      if (k == 2) section.count = value;
    }
    in_.words.line();
    section.position = in_.words.position();
    const bool at_points = section_name == "NodeData";
    const auto [place, is_new] = field_places_.try_emplace({at_points, name}, fields_.size());
    if (is_new) fields_.push_back({.name = name, .at_points = at_points, .sections = {}});
    fields_[place->second].sections.push_back(section);
    skip_section(section_name);
  }

  /// Replaces node numbers by node indices.
  void connect() {
    const IdPositions nodes(node_ids_);
    if (const auto twice = nodes.repeated())
      refuse_input(path_, "section Nodes", concat("node ", *twice, " twice"), "each number once");
    for (std::size_t c = 0; c < cells_.kinds.size(); ++c)
      for (std::uint64_t i = cells_.offsets[c]; i < cells_.offsets[c + 1]; ++i) {
        const std::optional<std::uint64_t> position = nodes.find(cells_.nodes[i]);
        if (!position)
          refuse_input(path_, concat("element ", element_ids_[c]),
                       concat("node ", static_cast<std::int64_t>(cells_.nodes[i])), "a node of section Nodes");
        cells_.nodes[i] = *position;
      }
  }

  void name_groups() {
    for (const auto& [name, groups] : {std::pair("physical", &physical_), std::pair("entity", &entity_)})
      mesh_.cell_fields.push_back(field_of(name, Array<double>(groups->begin(), groups->end())));
    mesh_.cell_fields.front().label_names = label_names_from(names_, mesh_.notes);
    if (volumes_in_several_groups_ > 0)
      mesh_.notes.push_back(concat(count_text(volumes_in_several_groups_, "volume belongs", "volumes belong"),
                                   " to several physical groups; cell field 'physical' has the first"));
  }

  void read_fields() {
    for (const std::string& name : left_out_)
      mesh_.notes.push_back(concat("section ", name, " left out: its values differ from cell to cell at a node"));
    if (fields_.empty()) return refuse_time_step(time_, path_);
    std::vector<Step> steps;
    for (Field& field : fields_) {
      field.count_steps();
      for (const Section& section : field.sections) steps.push_back(section.step);
    }
    std::sort(steps.begin(), steps.end());
    steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
    std::vector<double> times;
    for (const Step& step : steps) times.push_back(step.time);
    const Step chosen = steps[choose_time_step(times, time_, path_, mesh_.notes)];
    const IdPositions nodes(node_ids_), elements(element_ids_);
    for (const Field& field : fields_)
      if (const std::span<const Section> sections = field.at(chosen); !sections.empty())
        read_field(field, sections, field.at_points ? nodes : elements);
  }

  /// Points and cells without a value have no data: NaN.
  void read_field(const Field& field, std::span<const Section> sections, const IdPositions& owners) {
    if (const auto twice = owners.repeated(); twice && !field.at_points)
      refuse_input(path_, concat("field '", field.name, "'"), concat("two elements numbered ", *twice),
                   "each number once, to know which one a value is for");
    const int component_count = sections.front().component_count;
    const auto width = static_cast<std::size_t>(component_count);
    Array<double> numbers((field.at_points ? node_ids_ : element_ids_).size() * width,
                          std::numeric_limits<double>::quiet_NaN());
    std::uint64_t repeated = 0;  // numbers that another section, of another partition or field, gave before
    for (const Section& section : sections) {
      MshNumbers values(file_, section.position);
      if (section.component_count != component_count)
        values.words.refuse(concat(section.component_count, " components"),
                            concat(component_count, ", as in another section of field '", field.name, "'"));
      values.is_binary = in_.is_binary;
      values.is_big_endian = in_.is_big_endian;
      for (std::uint64_t i = 0; i < section.count; ++i) {
        const std::int32_t id = values.integer("a number of a node or element");
        const std::optional<std::uint64_t> owner = owners.find(static_cast<std::uint64_t>(id));
        if (!owner) values.words.refuse(concat(field.at_points ? "node " : "element ", id), "one that is there");
        for (std::size_t c = 0; c < width; ++c) {
          const double value = values.real("a value");
          double& number = numbers[*owner * width + c];
          if (std::isnan(number))
            number = value;
          else if (number != value)
            ++repeated;
        }
      }
      const std::string end = field.at_points ? "$EndNodeData" : "$EndElementData";
      if (const std::string_view word = values.words.word(end); word != end) values.words.refuse(word, end);
    }
    if (repeated > 0)
      mesh_.notes.push_back(concat("field '", field.name, "': ", count_text(repeated, "value", "values"),
                                   " left out: the file has another one at the same place and step"));
    (field.at_points ? mesh_.point_fields : mesh_.cell_fields)
        .push_back(field_of(field.name, std::move(numbers), component_count));
  }

  std::filesystem::path path_;
  ForeignFile file_;
  MshNumbers in_;
  std::string time_;
  bool is_4_ = false;
  CellMesh mesh_;
  /// holds node numbers until `connect`
  ForeignCells cells_{.kinds = {}, .offsets = {0}, .nodes = {}};
  Array<std::uint64_t> node_ids_, element_ids_;
  Array<std::int32_t> physical_, entity_;
  std::vector<std::uint64_t> given_;  ///< one element's nodes in Gmsh's order
  std::map<std::uint64_t, GmshElement> types_;
  std::map<std::int32_t, std::int32_t> groups_of_volumes_;
  GivenNames names_;  ///< of physical groups of volumes
  std::uint64_t volumes_in_several_groups_ = 0;
  /// sections that a file may contain once, with their content
  std::map<std::string, std::string_view> sections_;
  std::vector<Field> fields_;                                         ///< in the file's order
  std::map<std::pair<bool, std::string>, std::size_t> field_places_;  ///< in fields_, by at_points and name
  std::set<std::string> left_out_;
};

}  // namespace

CellMesh read_gmsh(const std::filesystem::path& path, const std::string& time) {
  return MshReader(path, time).read();
}

}  // namespace rhoray::preprocess
