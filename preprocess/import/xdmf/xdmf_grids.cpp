#include "preprocess/import/xdmf/xdmf_grids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/reading/time_steps.h"

namespace rhoray::preprocess {
namespace {

enum class GridKind { uniform, spatial, temporal };

GridKind kind_of(const XdmfDocument& document, const XmlElement& grid) {
  const std::string type = XdmfDocument::word(grid, {"GridType"});
  const std::string collection = XdmfDocument::word(grid, {"CollectionType"});
  if (type == "tree") return GridKind::spatial;
  if (type == "collection" || (type.empty() && !collection.empty())) {
    if (collection == "temporal") return GridKind::temporal;
    if (collection.empty() || collection == "spatial") return GridKind::spatial;
    document.refuse(grid, concat("a collection of the type ", in_quotes(collection)), "Spatial or Temporal",
                    ErrorCode::unsupported);
  }
  if (!type.empty() && type != "uniform")
    document.refuse(grid, concat("a Grid of the type ", in_quotes(type)), "Uniform, Collection or Tree",
                    ErrorCode::unsupported);
  return GridKind::uniform;
}

std::string name_of_grid(const XmlElement& grid) {
  return in_quotes(grid.attribute("Name"));
}

/// Takes a Grid, or all those inside it. Depth is bounded by that of the document.
void take_grids(const XdmfDocument& document, const XmlElement& element, std::vector<XdmfGrid>& to) {
  const GridKind kind = kind_of(document, element);
  if (kind == GridKind::temporal)
    document.refuse(element, "a collection over time inside another Grid", "one that contains all others",
                    ErrorCode::unsupported);
  if (kind == GridKind::spatial) {
    for (const XmlElement* child : document.children(element, "Grid")) take_grids(document, *child, to);
    return;
  }
  XdmfGrid grid{.element = &element,
                .topology = document.child(element, "Topology"),
                .geometry = document.child(element, "Geometry"),
                .attributes = document.children(element, "Attribute")};
  if (grid.topology == nullptr || grid.geometry == nullptr)
    document.refuse(element, grid.topology == nullptr ? "no Topology" : "no Geometry", "one");
  to.push_back(std::move(grid));
}

double time_in(const XdmfDocument& document, const XmlElement& time) {
  const std::string value = XdmfDocument::word(time, {"Value"});
  const std::optional<double> number = parse_number<double>(value);
  if (!number) document.refuse(time, concat("Value ", in_quotes(value)), "a number");
  return *number;
}

/// Times that a collection gives in one list, or as start, step and count; empty if it gives none.
std::vector<double> common_times(const XdmfDocument& document, XdmfData& data, const XmlElement& collection,
                                 std::size_t steps) {
  const XmlElement* time = document.child(collection, "Time");
  const std::string type = time == nullptr ? std::string() : XdmfDocument::word(*time, {"TimeType"});
  if (type != "list" && type != "hyperslab") return {};
  const XdmfNumbers numbers = data.open_only(*time);
  const std::size_t wanted = type == "list" ? steps : 3;
  if (numbers.count() != wanted) numbers.refuse(concat(numbers.count(), " numbers"), concat(wanted));
  const Array<double> given = numbers.read<double>();
  std::vector<double> times(given.begin(), given.end());
  if (type == "list") return times;
  times.resize(steps);
  for (std::size_t step = 0; step < steps; ++step) times[step] = given[0] + static_cast<double>(step) * given[1];
  return times;
}

/// A Grid of the domain. One that is no collection over time counts as its own only step.
struct TopGrid {
  const XmlElement* element = nullptr;
  bool has_steps = false;
  std::vector<const XmlElement*> steps{};
  std::vector<double> times{};  ///< NaN where none is given
};

TopGrid top_grid(const XdmfDocument& document, XdmfData& data, const XmlElement& element) {
  TopGrid top{.element = &element, .has_steps = kind_of(document, element) == GridKind::temporal};
  if (!top.has_steps) {
    top.steps = {&element};
    return top;
  }
  top.steps = document.children(element, "Grid");
  if (top.steps.empty()) document.refuse(element, "no Grid", "one for each time step");
  const std::vector<double> common = common_times(document, data, element, top.steps.size());
  for (std::size_t step = 0; step < top.steps.size(); ++step) {
    const XmlElement* time = document.child(*top.steps[step], "Time");
    const double otherwise = common.empty() ? std::numeric_limits<double>::quiet_NaN() : common[step];
    const bool has_own = time != nullptr && !time->attribute("Value").empty();
    top.times.push_back(has_own ? time_in(document, *time) : otherwise);
  }
  return top;
}

/// True when both have the same names, attributes, text and children.
bool is_same(const XmlElement& a, const XmlElement& b) {
  return &a == &b || (a.name == b.name && a.attributes == b.attributes && a.content == b.content &&
                      std::equal(a.children.begin(), a.children.end(), b.children.begin(), b.children.end(), is_same));
}

bool have_same_meshes(const std::vector<XdmfGrid>& a, const std::vector<XdmfGrid>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const XdmfGrid& one, const XdmfGrid& other) {
    return is_same(*one.topology, *other.topology) && is_same(*one.geometry, *other.geometry);
  });
}

/// The step of another Grid that goes with the chosen one: its only step, or the one of the same
/// time.
const XmlElement* step_beside(const TopGrid& other, const TopGrid& chosen, std::size_t step) {
  if (other.steps.size() == 1) return other.steps.front();
  const auto same = std::find(other.times.begin(), other.times.end(), chosen.times[step]);
  if (same != other.times.end()) return other.steps[static_cast<std::size_t>(same - other.times.begin())];
  const bool have_none = std::isnan(chosen.times[step]) && other.steps.size() == chosen.steps.size();
  return have_none ? other.steps[step] : nullptr;
}

/// Adds the attributes of another Grid on the same mesh, or a note.
void add_beside(const XdmfDocument& document, const TopGrid& other, const TopGrid& chosen, std::size_t step,
                XdmfGrids& result) {
  const XmlElement* beside = other.has_steps && chosen.has_steps ? step_beside(other, chosen, step)
                             : other.steps.size() == 1           ? other.steps.front()
                                                                 : nullptr;
  std::vector<XdmfGrid> grids;
  if (beside != nullptr) take_grids(document, *beside, grids);
  if (beside == nullptr || !have_same_meshes(result.grids, grids)) {
    result.notes.push_back(concat("grid ", name_of_grid(*other.element), " left out: it has another ",
                                  beside == nullptr ? "time" : "mesh", " than grid ", name_of_grid(*chosen.element)));
    return;
  }
  for (std::size_t i = 0; i < grids.size(); ++i)
    result.grids[i].attributes.insert(result.grids[i].attributes.end(), grids[i].attributes.begin(),
                                      grids[i].attributes.end());
}

/// Declared types with the counts of numbers that they allow.
struct DeclaredCount {
  std::string_view word;
  std::uint64_t least, most;
};
constexpr std::uint64_t most_components = 1024;
constexpr DeclaredCount declared_counts[] = {
    {"scalar", 1, 1}, {"vector", 2, most_components}, {"tensor", 4, most_components}, {"tensor6", 6, 6}};

/// Why an attribute is left out; empty when it is not.
std::string reason_against(const XdmfDocument& document, const XmlElement& attribute) {
  const std::string center = XdmfDocument::word(attribute, {"Center"}),
                    kind = XdmfDocument::word(attribute, {"ItemType"});
  if (!center.empty() && center != "node" && center != "cell")
    return concat("its values stand at ", in_quotes(center), ", not at nodes or in cells");
  if (!kind.empty() && kind != "uniform") return concat("it is a ", in_quotes(attribute.attribute("ItemType")));
  const XmlElement* item = document.child(attribute, "DataItem");
  if (item != nullptr && XdmfDocument::word(*item, {"ItemType"}) == "function") return "a function computes it";
  return {};
}

}  // namespace

std::string topology_word(const XmlElement& topology) {
  return XdmfDocument::word(topology, {"TopologyType", "Type"});
}

XdmfGrids select_grids(const XdmfDocument& document, XdmfData& data, const XdmfGridRequest& request) {
  const auto domains = document.children(document.root(), "Domain");
  if (domains.empty()) document.refuse(document.root(), "no Domain", "one");
  std::vector<TopGrid> tops;
  for (const XmlElement* grid : document.children(*domains.front(), "Grid"))
    tops.push_back(top_grid(document, data, *grid));
  if (tops.empty()) document.refuse(*domains.front(), "no Grid", "at least one");
  const auto rank = [&](const TopGrid& top) {
    std::vector<XdmfGrid> grids;
    take_grids(document, *top.steps.back(), grids);
    const bool wanted = std::any_of(grids.begin(), grids.end(), [&](const XdmfGrid& grid) {
      return request.is_wanted(topology_word(*grid.topology));
    });
    return (wanted ? 2 : 0) + (top.has_steps ? 1 : 0);
  };
  std::vector<int> ranks;
  for (const TopGrid& top : tops) ranks.push_back(rank(top));
  const auto chosen = tops.begin() + (std::max_element(ranks.begin(), ranks.end()) - ranks.begin());
  XdmfGrids result;
  if (domains.size() > 1) result.notes.push_back("only the first of several Domains was read");
  std::size_t step = 0;
  if (!chosen->has_steps)
    refuse_time_step(request.time, document.path());
  else if (!request.first_by_default || !request.time.empty())
    step = choose_time_step(chosen->times, request.time, document.path(), result.notes);
  else if (chosen->steps.size() > 1)
    result.notes.push_back(
        concat("using the first of ", chosen->steps.size(), " time steps; choose another with --time"));
  take_grids(document, *chosen->steps[step], result.grids);
  if (result.grids.empty()) document.refuse(*chosen->element, "no Grid", "at least one");
  for (auto top = tops.begin(); top != tops.end(); ++top)
    if (top != chosen) add_beside(document, *top, *chosen, step, result);
  return result;
}

int XdmfAttribute::component_count(std::uint64_t owners) const {
  const std::uint64_t each = owners == 0 ? 0 : numbers.count() / owners;
  if (owners == 0 ? numbers.count() != 0 : numbers.count() % owners != 0 || each < 1 || each > most_components)
    numbers.refuse(concat(numbers.count(), " numbers of attribute ", in_quotes(name)),
                   concat("1 to ", most_components, " for each of ", owners, in_cells ? " cells" : " points"));
  for (const DeclaredCount& row : declared_counts)
    if (owners > 0 && row.word == declared && (each < row.least || each > row.most))
      numbers.refuse(concat(each, " numbers for each ", in_cells ? "cell" : "point"),
                     concat(row.least, row.least == row.most ? "" : " or more", ", as a ", declared, " has"));
  return owners == 0 ? 1 : static_cast<int>(each);
}

std::vector<XdmfAttribute> attributes_of(const XdmfDocument& document, XdmfData& data, const XdmfGrid& grid,
                                         std::vector<std::string>& notes) {
  std::vector<XdmfAttribute> attributes;
  std::set<std::pair<std::string, bool>> names;
  for (const XmlElement* element : grid.attributes) {
    const std::string name(element->attribute("Name"));
    const bool in_cells = XdmfDocument::word(*element, {"Center"}) == "cell";
    std::string reason = reason_against(document, *element);
    if (reason.empty() && !names.emplace(name, in_cells).second) reason = "another has the same name";
    if (!reason.empty()) {
      notes.push_back(concat("attribute ", in_quotes(name), " left out: ", reason));
      continue;
    }
    const std::string declared = XdmfDocument::word(*element, {"AttributeType", "Type"});
    attributes.push_back({.name = name.empty() ? "unnamed" : name,
                          .in_cells = in_cells,
                          .is_symmetric_tensor = declared == "tensor6",
                          .declared = declared,
                          .numbers = data.open_only(*element)});
  }
  return attributes;
}

Array<std::array<double, 3>> points_of(const XdmfDocument& document, XdmfData& data, const XmlElement& geometry) {
  std::string type = XdmfDocument::word(geometry, {"GeometryType", "Type"});
  if (type.empty()) type = "xyz";
  const std::size_t axes = type == "xy" || type == "x_y" ? 2 : 3;
  const bool is_together = type == "xyz" || type == "xy";
  if (!is_together && type != "x_y_z" && type != "x_y")
    document.refuse(geometry, concat("points of the type ", in_quotes(type)), "XYZ, XY, X_Y_Z or X_Y",
                    ErrorCode::unsupported);
  const auto items = document.children(geometry, "DataItem");
  if (items.size() != (is_together ? 1 : axes))
    document.refuse(geometry, concat(items.size(), " elements DataItem"), concat(is_together ? 1 : axes));
  std::vector<XdmfNumbers> arrays;
  for (const XmlElement* item : items) arrays.push_back(data.open(*item));
  const std::uint64_t count = is_together ? arrays.front().count() / axes : arrays.front().count();
  for (const XdmfNumbers& array : arrays)
    if (array.count() != (is_together ? count * axes : count))
      array.refuse(concat(array.count(), " coordinates"),
                   is_together ? concat(axes, " for each point") : concat(count, ", as along the first axis"));
  Array<std::array<double, 3>> points(count, {0, 0, 0});
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const Array<double> numbers = arrays[i].read<double>();
    for (std::uint64_t p = 0; p < count; ++p)
      for (std::size_t axis = 0; axis < (is_together ? axes : 1); ++axis)
        points[p][is_together ? axis : i] = numbers[is_together ? p * axes + axis : p];
  }
  return points;
}

}  // namespace rhoray::preprocess
