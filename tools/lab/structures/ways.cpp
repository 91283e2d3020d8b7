#include "tools/lab/structures/ways.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

#include "preprocess/pack_mesh.h"
#include "tools/analysis/cpu_meter.h"
#include "tools/lab/structures/cell_orders.h"
#include "tools/lab/structures/cluster_tree.h"
#include "tools/lab/structures/mailbox.h"
#include "tools/lab/structures/octree.h"
#include "tools/lab/structures/ordered_lists.h"
#include "tools/lab/structures/plain_mesh.h"
#include "tools/lab/structures/two_level_grid.h"

namespace rhoray::study {
namespace {

using preprocess::MeshStructure;
using preprocess::PackMeshOptions;
using render::Hit;
using render::KernelCounters;
using render::Ray;
using render::RayQuery;
using PackedVolume = render::TetData;
using Items = std::span<const std::uint32_t>;

struct PackedName {
  const char* name;
  PackMeshOptions options;
};
constexpr std::size_t lists_of_one = 0, clusters_of_64 = 2;  // indices in packed_ways()

std::vector<PackedName> packed_ways() {
  return {{"leaf lists, a leaf for each cell", {.structure = MeshStructure::leaves}},
          {"leaf lists, a leaf for 8 cells", {.structure = MeshStructure::leaves, .leaf_cells_per_tetrahedron = 0.125}},
          {"clusters of 64", {}},
          {"clusters of 32", {.cluster_size = 32}},
          {"clusters of 8", {.cluster_size = 8}}};
}

preprocess::NeutralMesh with_floats(preprocess::NeutralMesh mesh) {
  for (auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    for (preprocess::NeutralField& field : *fields) {
      field.was_single_precision = true;
      for (double& value : field.values) value = static_cast<double>(static_cast<float>(value));
    }
  return mesh;
}

/// Total bytes of the file's arrays whose names satisfy the predicate.
template <class IsMeant>
std::uint64_t bytes_of(const formats::PackedFile& file, IsMeant&& is_meant) {
  std::uint64_t bytes = 0;
  for (const formats::ArrayEntry& entry : file.arrays())
    if (is_meant(entry.name)) bytes += entry.byte_count;
  return bytes;
}

/// Bytes of everything except points, fields and envelope.
std::uint64_t structure_bytes(const formats::PackedFile& file) {
  return bytes_of(file, [](const std::string& name) {
    return name != "points" && !name.starts_with("field.") && !name.starts_with('_');
  });
}

/// Bytes of the arrays that lead from cells and points to the source, for any structure.
std::uint64_t source_bytes(const formats::PackedFile& file) {
  return bytes_of(file, [](const std::string& name) { return name == "cell_ids" || name == "point_ranks"; });
}

/// Bytes of the cells as stored in clusters, and of the clusters' tables.
std::uint64_t compressed_cell_bytes(const formats::PackedFile& file) {
  return bytes_of(file, [](const std::string& name) {
    return name == "cluster.corners" || name == "cluster.offsets" || name == "cluster.vertices";
  });
}

/// Answers rays by a traversal that finds the cells of a mesh.
/// @param walk  (query, ray, counters, matters_from, look, ends_at)
template <class Mesh, class Walk>
auto asked(std::shared_ptr<const Mesh> mesh, double isovalue, Walk walk) {
  return [mesh, isovalue, walk](std::span<const Ray> rays, std::span<Hit> hits, KernelCounters& counters) {
    const RayQuery query{.isovalue = isovalue};
    for (std::size_t r = 0; r < rays.size(); ++r)
      hits[r] = render::nearest_crossing<double>(*mesh, query, rays[r],
                                                 [&](auto&& matters_from, auto&& look, auto&& ends_at) {
                                                   walk(query, rays[r], counters, matters_from, look, ends_at);
                                                 });
  };
}

/// Uses the lists of cells that a structure provides. The mailbox determines whether a cell is
/// tested only once.
template <class Mesh, class Structure, class Mailbox>
auto asked_by_lists(std::shared_ptr<const Mesh> mesh, double isovalue, std::shared_ptr<const Structure> structure,
                    Mailbox empty) {
  const auto mailbox = std::make_shared<Mailbox>(std::move(empty));
  return asked(mesh, isovalue,
               [mesh, structure, mailbox](const RayQuery& query, const Ray& ray, KernelCounters& counters,
                                          auto&& matters_from, auto&& look, auto&& ends_at) {
                 mailbox->begin_ray();
                 structure->walk(
                     query, ray, counters, matters_from,
                     [&](Items list) {
                       for (const std::uint32_t tet : list)
                         if (mailbox->is_new(tet)) render::look_into(*mesh, query, tet, counters, look);
                     },
                     ends_at);
               });
}

/// Uses lists of cells whose ranges are in a separate array. If is_rising, the cells of a list are
/// in ascending order of their smallest values, and the list ends where one is too large.
auto asked_by_rising_values(std::shared_ptr<const PlainMesh> mesh, double isovalue,
                            std::shared_ptr<const OrderedLists> lists, bool is_rising) {
  std::vector<Interval<float>> ranges;
  for (std::uint32_t cell = 0; cell < mesh->cell_count(); ++cell) ranges.push_back(mesh->range(cell));
  return asked(mesh, isovalue,
               [mesh, lists, is_rising, ranges = std::make_shared<const std::vector<Interval<float>>>(ranges)](
                   const RayQuery& query, const Ray& ray, KernelCounters& counters, auto&& matters_from, auto&& look,
                   auto&& ends_at) {
                 lists->walk(
                     query, ray, counters, matters_from,
                     [&](Items list) {
                       for (const std::uint32_t tet : list) {
                         const Interval<float>& range = (*ranges)[tet];
                         if (is_rising && !(range.lo < query.isovalue)) break;
                         if (range.lo < query.isovalue && query.isovalue <= range.hi)
                           render::look_into(*mesh, query, tet, counters, look);
                       }
                     },
                     ends_at);
               });
}

/// The cells of a mesh with a tree over them.
template <class Mesh, class Tree>
struct TreeView {
  const Mesh& mesh;
  const Tree& tree;

  const formats::CellClustersView& clusters() const { return tree.clusters(); }
  template <class Act>
  RHORAY_INLINE auto with_cluster_ranges(int level, std::uint64_t block, Act&& act) const {
    return tree.with_cluster_ranges(level, block, act);
  }
  RHORAY_INLINE auto vertices(std::uint32_t cell) const { return mesh.vertices(cell); }
  RHORAY_INLINE auto sorted_vertices(std::uint32_t cell) const { return mesh.sorted_vertices(cell); }
  template <class Vertices>
  RHORAY_INLINE std::array<double, 4> values_at(const Vertices& v) const {
    return mesh.values_at(v);
  }
  template <class Vertices>
  RHORAY_INLINE std::array<std::array<double, 3>, 4> points_at(const Vertices& v) const {
    return mesh.points_at(v);
  }
};

/// Uses clusters: a mesh's own, or others over its cells.
template <class Mesh, class Clusters>
auto asked_by_clusters(std::shared_ptr<const Mesh> mesh, double isovalue, std::shared_ptr<const Clusters> clusters) {
  return asked(mesh, isovalue,
               [mesh, clusters](const RayQuery& query, const Ray& ray, KernelCounters& counters, auto&& matters_from,
                                auto&& look, auto&&) {
                 render::walk_active_clusters(TreeView<Mesh, Clusters>{*mesh, *clusters}, query, ray, counters,
                                              matters_from, look);
               });
}

std::vector<std::uint32_t> inverse(std::span<const std::uint32_t> order) {
  std::vector<std::uint32_t> inverse(order.size());
  for (std::size_t n = 0; n < order.size(); ++n) inverse[order[n]] = static_cast<std::uint32_t>(n);
  return inverse;
}

}  // namespace

struct MeshForWays::File {
  std::string name;
  double pack_s = 0;
  formats::TetMeshDescription description{};
  std::optional<render::Dataset> dataset{};
  std::shared_ptr<const PackedVolume> view{};

  double cells() const { return static_cast<double>(description.cell_count); }
  double per_cell(std::uint64_t bytes) const { return static_cast<double>(bytes) / cells(); }
};

struct MeshForWays::Parts {
  std::vector<File> files;
  std::shared_ptr<const PlainMesh> plain;
};

MeshForWays::MeshForWays(preprocess::NeutralMesh mesh, const std::filesystem::path& folder)
    : parts_(std::make_unique<Parts>()) {
  mesh = with_floats(std::move(mesh));
  tools::CpuMeter meter;
  for (const PackedName& way : packed_ways()) {
    File& file = parts_->files.emplace_back(File{.name = way.name});
    const std::filesystem::path path = folder / concat("packed_", parts_->files.size(), ".rho");
    PackMeshOptions options = way.options;
    options.replace_existing = true;
    file.pack_s =
        meter.measure([&] { file.description = preprocess::pack_mesh(mesh, path, options).description; }).cpu_s;
    file.dataset = render::Dataset::load(path);
    file.view = std::make_shared<PackedVolume>(formats::TetMesh(file.dataset->file()), 0);
  }
  parts_->plain = std::make_shared<PlainMesh>(parts_->files[clusters_of_64].view->mesh());
}

MeshForWays::~MeshForWays() = default;

const render::Dataset& MeshForWays::dataset() const {
  return *parts_->files[clusters_of_64].dataset;
}

const formats::TetMesh& MeshForWays::packed() const {
  return parts_->files[clusters_of_64].view->mesh();
}

std::vector<Way> MeshForWays::structures(double isovalue) const {
  std::vector<Way> ways;
  for (const File& file : parts_->files) {
    const std::uint64_t named =
        file.view->has_clusters() ? file.description.cell_count : file.description.leaf_item_count;
    ways.push_back({.name = file.name,
                    .bytes_per_cell = file.per_cell(structure_bytes(file.dataset->file())),
                    .named_per_cell = file.per_cell(named),
                    .cells_per_cpu_s = file.cells() / file.pack_s,
                    .ask = asked(file.view, isovalue,
                                 [view = file.view](const RayQuery& query, const Ray& ray, KernelCounters& counters,
                                                    auto&& matters_from, auto&& look, auto&& ends_at) {
                                   render::walk_active_tets(*view, query, ray, counters, matters_from, look, ends_at);
                                 })});
  }
  // The scalar kernel reads the values of a cell in each list that contains it; the grids below
  // check that before.
  const File& lists = parts_->files[lists_of_one];
  Way each_once = ways[lists_of_one];
  each_once.name += ", a mailbox";
  each_once.ask = asked_by_lists(parts_->plain, isovalue,
                                 std::make_shared<const OrderedLists>(*lists.view, [](std::span<std::uint32_t>) {}),
                                 ExactMailbox(parts_->plain->cell_count()));
  ways.insert(ways.begin() + 1, std::move(each_once));
  const File& file = parts_->files[clusters_of_64];
  const double fixed_bytes = PlainMesh::cell_bytes + file.per_cell(source_bytes(file.dataset->file()));
  tools::CpuMeter meter;
  const auto add = [&](const std::string& name, const auto& build) {
    std::invoke_result_t<decltype(build)> structure;
    const double build_s = meter.measure([&] { structure = build(); }).cpu_s;
    ways.push_back(
        {.name = name,
         .bytes_per_cell = fixed_bytes + file.per_cell(structure->bytes()),
         .named_per_cell = file.per_cell(structure->item_count()),
         .cells_per_cpu_s = file.cells() / build_s,
         .ask = asked_by_lists(parts_->plain, isovalue, structure, ExactMailbox(parts_->plain->cell_count()))});
  };
  for (const double cells : {8.0, 64.0, 512.0})
    add(concat("two-level grid, ", cells, " cells above"),
        [&] { return std::make_shared<const TwoLevelGrid>(*parts_->plain, cells); });
  for (const std::size_t most : {1U, 4U, 16U})
    add(concat("octree, ", most, most == 1 ? " cell" : " cells", " a leaf"),
        [&] { return std::make_shared<const Octree>(*parts_->plain, most); });
  return ways;
}

std::vector<Way> MeshForWays::orders(double isovalue) const {
  std::vector<Way> ways;
  const std::shared_ptr<const PlainMesh>& plain = parts_->plain;
  const File& lists = parts_->files[lists_of_one];
  const File& clusters = parts_->files[clusters_of_64];
  const double list_bytes = lists.per_cell(structure_bytes(lists.dataset->file()));
  const double items = lists.per_cell(lists.description.leaf_item_count);
  const auto in_order = [&](const std::function<void(std::span<std::uint32_t>)>& reorder) {
    return std::make_shared<const OrderedLists>(*lists.view, reorder);
  };
  const auto as_packed = in_order([](std::span<std::uint32_t>) {});
  const auto add_lists = [&](const std::string& name, double further_bytes, const auto& ask) {
    ways.push_back({.name = concat("leaf lists: ", name),
                    .bytes_per_cell = list_bytes + further_bytes,
                    .named_per_cell = items,
                    .ask = ask});
  };

  add_lists("as packed", 0, asked_by_lists(plain, isovalue, as_packed, NoMailbox{}));
  add_lists("a small mailbox", 0, asked_by_lists(plain, isovalue, as_packed, SmallMailbox{}));
  add_lists("a mailbox for each cell", 0,
            asked_by_lists(plain, isovalue, as_packed, ExactMailbox(plain->cell_count())));
  add_lists("items shuffled", 0,
            asked_by_lists(plain, isovalue, in_order([](std::span<std::uint32_t> list) {
                             std::mt19937_64 random(list.size());
                             std::shuffle(list.begin(), list.end(), random);
                           }),
                           NoMailbox{}));
  add_lists("items by size, the largest first", 0,
            asked_by_lists(plain, isovalue, in_order([&](std::span<std::uint32_t> list) {
                             std::stable_sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
                               return plain->box(a).size().length() > plain->box(b).size().length();
                             });
                           }),
                           NoMailbox{}));
  constexpr double range_bytes = sizeof(Interval<float>);
  add_lists("ranges of cells beside them", range_bytes, asked_by_rising_values(plain, isovalue, as_packed, false));
  add_lists("ranges beside them, items by smallest value", range_bytes,
            asked_by_rising_values(plain, isovalue, in_order([&](std::span<std::uint32_t> list) {
                                     std::stable_sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
                                       return plain->range(a).lo < plain->range(b).lo;
                                     });
                                   }),
                                   true));
  using Order = std::pair<const char*, std::vector<std::uint32_t>>;
  for (const auto& [name, order] :
       {Order("cells as made", as_made(*plain)), Order("cells shuffled", shuffled(*plain))}) {
    const std::vector<std::uint32_t> place = inverse(order);
    const auto moved = std::make_shared<const PlainMesh>(plain->reordered(order));
    add_lists(name, 0,
              asked_by_lists(moved, isovalue, in_order([&](std::span<std::uint32_t> list) {
                               for (std::uint32_t& cell : list) cell = place[cell];
                               std::sort(list.begin(), list.end());
                             }),
                             NoMailbox{}));
  }

  const double fixed_bytes = clusters.per_cell(source_bytes(clusters.dataset->file()));
  const double tree_bytes = clusters.per_cell(structure_bytes(clusters.dataset->file())) - fixed_bytes -
                            clusters.per_cell(compressed_cell_bytes(clusters.dataset->file()));
  const auto add_clusters = [&](const std::string& name, double bytes, const auto& ask) {
    ways.push_back({.name = concat("clusters of ", name), .bytes_per_cell = bytes, .named_per_cell = 1, .ask = ask});
  };
  add_clusters("64: as packed", clusters.per_cell(structure_bytes(clusters.dataset->file())),
               asked_by_clusters(clusters.view, isovalue, clusters.view));
  add_clusters("64: cells of 16 bytes", fixed_bytes + tree_bytes + PlainMesh::cell_bytes,
               asked_by_clusters(plain, isovalue, clusters.view));
  for (const std::uint64_t size : {64, 8})
    for (const auto& [name, order] :
         {Order("as made", as_made(*plain)), Order("along Morton's curve", by_morton(*plain)),
          Order("along Hilbert's curve", by_hilbert(*plain)), Order("by halves", as_they_stand(*plain))}) {
      const auto moved = std::make_shared<const PlainMesh>(plain->reordered(order));
      const auto tree = std::make_shared<const ClusterTree>(*moved, size);
      add_clusters(concat(size, ": cells of 16 bytes ", name),
                   fixed_bytes + PlainMesh::cell_bytes + clusters.per_cell(tree->bytes()),
                   asked_by_clusters(moved, isovalue, tree));
    }
  return ways;
}

std::vector<MeshForWays::RoundedWay> MeshForWays::rounded(double isovalue) const {
  const File& file = parts_->files[clusters_of_64];
  std::vector<RoundedWay> ways;
  const auto add = [&]<class Mesh>(const std::string& name, Mesh made) {
    const auto mesh = std::make_shared<const Mesh>(std::move(made));
    ways.push_back({{.name = name,
                     .bytes_per_cell = file.per_cell(mesh->bytes()),
                     .named_per_cell = 1,
                     .ask = asked_by_clusters(mesh, isovalue, file.view)},
                    shape_of(*mesh)});
  };
  add("doubles", DoublePoints(packed()));
  add("floats", FloatPoints(packed()));
  add("21 bits an axis on one lattice", LatticePoints(packed()));
  add("16 bits an axis in each cluster's box", ClusterPoints<SixteenBits>(packed()));
  add("11, 11 and 10 bits in each cluster's box", ClusterPoints<ElevenBits>(packed()));
  return ways;
}

}  // namespace rhoray::study
