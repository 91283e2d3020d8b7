// In which order to look for the largest values along the rays of a picture: regions, cells and cubics that each order
// looks at, for rays alone and for groups of 8 x 8 pixels.

#include "tools/study/maximum_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>

#include "formats/brick_grid.h"
#include "tools/rhoray/option_values.h"
#include "tools/study/study_run.h"

namespace rhoray::study {
namespace {

using tools::Json;

struct Wishes {
  tools::CommonOptions common;
  std::filesystem::path file;
  std::uint64_t groups = 400;  ///< of each view
};

constexpr float nothing = -std::numeric_limits<float>::infinity();

/// Largest values of cubes of 1, 4 and 16 cells per axis, x fastest.
struct Level {
  std::int64_t edge = 1;
  Index3 count;
  std::vector<float> largest;

  std::size_t at(const Index3& cell) const {
    return static_cast<std::size_t>((cell.z * count.y + cell.y) * count.x + cell.x);
  }
};

/// Samples as floats, and their hierarchy.
struct Field {
  Index3 samples;
  std::vector<float> values;
  std::array<Level, 3> levels;

  float sample(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return values[static_cast<std::size_t>((k * samples.y + j) * samples.x + i)];
  }
};

Level leaf_level(const Field& field) {
  Level level{1, field.samples - Index3(1), {}};
  level.largest.reserve(static_cast<std::size_t>(level.count.x * level.count.y * level.count.z));
  for (std::int64_t k = 0; k < level.count.z; ++k)
    for (std::int64_t j = 0; j < level.count.y; ++j)
      for (std::int64_t i = 0; i < level.count.x; ++i) {
        float largest = nothing;
        for (int corner = 0; corner < 8; ++corner)
          largest = std::max(largest, field.sample(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)));
        level.largest.push_back(largest);
      }
  return level;
}

Level level_above(const Level& below) {
  Level level{below.edge * 4, {}, {}};
  for (int axis = 0; axis < 3; ++axis) level.count[axis] = (below.count[axis] + 3) / 4;
  level.largest.assign(static_cast<std::size_t>(level.count.x * level.count.y * level.count.z), nothing);
  for (std::int64_t k = 0; k < below.count.z; ++k)
    for (std::int64_t j = 0; j < below.count.y; ++j)
      for (std::int64_t i = 0; i < below.count.x; ++i) {
        float& largest = level.largest[level.at({i / 4, j / 4, k / 4})];
        largest = std::max(largest, below.largest[below.at({i, j, k})]);
      }
  return level;
}

template <class T>
Field field_of(const formats::BrickGrid& grid) {
  Field field{grid.description().layout.sample_count, {}, {}};
  const std::span<const T> stored = grid.samples<T>();
  field.values.reserve(static_cast<std::size_t>(field.samples.x * field.samples.y * field.samples.z));
  for (std::int64_t k = 0; k < field.samples.z; ++k)
    for (std::int64_t j = 0; j < field.samples.y; ++j)
      for (std::int64_t i = 0; i < field.samples.x; ++i)
        field.values.push_back(static_cast<float>(stored[grid.tables().address(i, j, k)]));
  field.levels[0] = leaf_level(field);
  field.levels[1] = level_above(field.levels[0]);
  field.levels[2] = level_above(field.levels[1]);
  return field;
}

Field load(const std::filesystem::path& path) {
  const formats::BrickGrid grid{formats::PackedFile::open(path)};
  if (grid.description().layout.is_sparse)
    throw Error(Trouble::unsupported, concat(path.string(), ": a sparse grid; expected a dense one"));
  return formats::with_element_type(grid.description().fields.front().type,
                                    [&](auto of_type) { return field_of<decltype(of_type)>(grid); });
}

struct Line {
  Vec3 origin, direction;
};

/// A part of a ray inside one cell of a level.
struct Passage {
  Index3 cell;
  float bound;
  double t_in, t_out;
};

/// The passages through cells of one level inside the box [low, high), front to back.
template <class Visit>
void walk(const Level& level, const Line& ray, double t_in, double t_out, Visit&& visit) {
  const double edge = static_cast<double>(level.edge);
  Index3 cell;
  double exits[3], per_cell[3];
  std::int64_t step[3];
  const double inside = t_in + 1e-9 * (t_out - t_in);
  for (int a = 0; a < 3; ++a) {
    const double p = (ray.origin[a] + inside * ray.direction[a]) / edge;
    cell[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(p)), 0, level.count[a] - 1);
    step[a] = ray.direction[a] > 0 ? 1 : -1;
    const double next = edge * static_cast<double>(cell[a] + (step[a] > 0));
    exits[a] = (next - ray.origin[a]) / ray.direction[a];
    per_cell[a] = std::abs(edge / ray.direction[a]);
  }
  for (double t = t_in; t < t_out;) {
    const int axis = exits[0] <= exits[1] ? (exits[0] <= exits[2] ? 0 : 2) : (exits[1] <= exits[2] ? 1 : 2);
    const double leave = std::min(exits[axis], t_out);
    if (leave > t) visit(Passage{cell, level.largest[level.at(cell)], t, leave});
    t = std::max(t, leave);
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= level.count[axis]) return;
    exits[axis] += per_cell[axis];
  }
}

std::optional<std::pair<double, double>> clip(const Field& field, const Line& ray) {
  double t_in = 0, t_out = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double t0 = -ray.origin[a] / ray.direction[a];
    const double t1 = (static_cast<double>(field.samples[a] - 1) - ray.origin[a]) / ray.direction[a];
    t_in = std::max(t_in, std::min(t0, t1)), t_out = std::min(t_out, std::max(t0, t1));
  }
  if (!(t_in < t_out)) return std::nullopt;
  return std::pair(t_in, t_out);
}

/// What a search looked at. Of groups: regions count once for all rays.
struct Work {
  double regions = 0;    ///< bounds of cubes of 16 and of 4 cells that were read
  double blocks = 0;     ///< cubes of 4 cells that were opened
  double in_blocks = 0;  ///< (ray, cube of 4 cells) in which cells were walked
  double cells = 0;      ///< (ray, cell) whose bound was looked at
  double cubics = 0;     ///< formed
  double solved = 0;     ///< of these, those whose critical points were looked for

  void add(const Work& other) {
    regions += other.regions, blocks += other.blocks, in_blocks += other.in_blocks;
    cells += other.cells, cubics += other.cubics, solved += other.solved;
  }
};

struct Best {
  double value = -std::numeric_limits<double>::infinity();
  double t = std::numeric_limits<double>::infinity();

  /// False where a region that begins at t_in can change nothing.
  bool may_improve(double bound, double t_in) const { return bound > value || (bound == value && t_in < t); }
  void offer(double found, double at) {
    if (found > value || (found == value && at < t)) value = found, t = at;
  }
};

double at_point(const Field& field, const Index3& cell, const Vec3& p) {
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    sum += (i ? p.x : 1 - p.x) * (j ? p.y : 1 - p.y) * (k ? p.z : 1 - p.z) *
           static_cast<double>(field.sample(cell.x + i, cell.y + j, cell.z + k));
  }
  return sum;
}

Vec3 in_cell(const Line& ray, const Index3& cell, double t) {
  Vec3 p;
  for (int a = 0; a < 3; ++a)
    p[a] = std::clamp(ray.origin[a] + t * ray.direction[a] - static_cast<double>(cell[a]), 0.0, 1.0);
  return p;
}

/// The largest value in a cell, by the critical points of the cubic where its control points lie above what is known.
void look_into_cell(const Field& field, const Line& ray, const Passage& cell, Best& best, Work& work) {
  ++work.cubics;
  const Vec3 p = in_cell(ray, cell.cell, cell.t_in), q = in_cell(ray, cell.cell, cell.t_out);
  const auto g = [&](int a, int b, int c) {
    return at_point(field, cell.cell, {a ? q.x : p.x, b ? q.y : p.y, c ? q.z : p.z});
  };
  const double b[] = {g(0, 0, 0), (g(1, 0, 0) + g(0, 1, 0) + g(0, 0, 1)) / 3,
                      (g(1, 1, 0) + g(1, 0, 1) + g(0, 1, 1)) / 3, g(1, 1, 1)};
  best.offer(b[0], cell.t_in), best.offer(b[3], cell.t_out);
  if (!best.may_improve(std::max(b[1], b[2]), cell.t_in)) return;
  ++work.solved;
  const double d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
  const double a = d0 - 2 * d1 + d2, half_b = d1 - d0, discriminant = d1 * d1 - d0 * d2;
  if (!(discriminant >= 0)) return;
  const double turn = -(half_b + std::copysign(std::sqrt(discriminant), half_b));
  for (const double s : {turn / a, d0 / turn})
    if (s > 0 && s < 1) {
      const double r = 1 - s;
      best.offer(r * r * r * b[0] + 3 * r * s * (r * b[1] + s * b[2]) + s * s * s * b[3],
                 cell.t_in + s * (cell.t_out - cell.t_in));
    }
}

void look_into_block(const Field& field, const Line& ray, const Passage& block, Best& best, Work& work) {
  ++work.in_blocks;
  walk(field.levels[0], ray, block.t_in, block.t_out, [&](const Passage& cell) {
    ++work.cells;
    if (best.may_improve(cell.bound, cell.t_in)) look_into_cell(field, ray, cell, best, work);
  });
}

/// A value that the ray reaches at t.
void guess(const Field& field, const Line& ray, double t, Best& best) {
  Index3 cell;
  for (int a = 0; a < 3; ++a)
    cell[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(ray.origin[a] + t * ray.direction[a])), 0,
                                       field.levels[0].count[a] - 1);
  const double value = at_point(field, cell, in_cell(ray, cell, t));
  best.offer(value - 1e-9 * std::abs(value), std::numeric_limits<double>::infinity());
}

// ---- rays alone

/// The paper's queue: the region with the largest bound first, down to cells.
void queue(const Field& field, const Line& ray, double t_in, double t_out, Best& best, Work& work) {
  struct Entry {
    Passage at;
    int level;
  };
  const auto later = [](const Entry& a, const Entry& b) {
    return a.at.bound != b.at.bound ? a.at.bound < b.at.bound : a.at.t_in > b.at.t_in;
  };
  std::vector<Entry> heap;
  const auto put = [&](int level, double from, double to) {
    if (level == 0) ++work.in_blocks;
    walk(field.levels[static_cast<std::size_t>(level)], ray, from, to, [&](const Passage& at) {
      ++(level > 0 ? work.regions : work.cells);
      if (!best.may_improve(at.bound, at.t_in)) return;
      heap.push_back({at, level});
      std::push_heap(heap.begin(), heap.end(), later);
    });
  };
  put(2, t_in, t_out);
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), later);
    const Entry entry = heap.back();
    heap.pop_back();
    if (!best.may_improve(entry.at.bound, entry.at.t_in)) continue;
    if (entry.level == 0)
      look_into_cell(field, ray, entry.at, best, work);
    else
      put(entry.level - 1, entry.at.t_in, entry.at.t_out);
  }
}

void front_to_back(const Field& field, const Line& ray, double t_in, double t_out, Best& best, Work& work) {
  walk(field.levels[2], ray, t_in, t_out, [&](const Passage& node) {
    ++work.regions;
    if (!best.may_improve(node.bound, node.t_in)) return;
    walk(field.levels[1], ray, node.t_in, node.t_out, [&](const Passage& block) {
      ++work.regions;
      if (best.may_improve(block.bound, block.t_in)) look_into_block(field, ray, block, best, work);
    });
  });
}

// ---- groups

/// A region that rays of a group pass, and which.
struct Shared {
  Index3 cell;
  float bound;
  double nearest;
  std::vector<std::pair<std::size_t, Passage>> rays;
};

struct Group {
  std::vector<Line> rays;
  std::vector<std::pair<double, double>> inside;
};

std::vector<Shared> shared_regions(const Field& field, const Group& group, int level_index) {
  const Level& level = field.levels[static_cast<std::size_t>(level_index)];
  struct Named {
    std::size_t id, ray;
    Passage at;
  };
  std::vector<Named> all;
  for (std::size_t r = 0; r < group.rays.size(); ++r)
    walk(level, group.rays[r], group.inside[r].first, group.inside[r].second, [&](const Passage& at) {
      all.push_back({level.at(at.cell), r, at});
    });
  std::stable_sort(all.begin(), all.end(), [](const Named& a, const Named& b) { return a.id < b.id; });
  std::vector<Shared> regions;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || all[i].id != all[i - 1].id) regions.push_back({all[i].at.cell, all[i].at.bound, all[i].at.t_in, {}});
    regions.back().nearest = std::min(regions.back().nearest, all[i].at.t_in);
    regions.back().rays.emplace_back(all[i].ray, all[i].at);
  }
  return regions;
}

bool any_may_improve(const Shared& region, const std::vector<Best>& best) {
  return std::any_of(region.rays.begin(), region.rays.end(),
                     [&](const auto& at) { return best[at.first].may_improve(at.second.bound, at.second.t_in); });
}

void open(const Field& field, const Group& group, const Shared& block, std::vector<Best>& best, Work& work) {
  ++work.blocks;
  for (const auto& [ray, at] : block.rays)
    if (best[ray].may_improve(at.bound, at.t_in)) look_into_block(field, group.rays[ray], at, best[ray], work);
}

enum class Order { bound, bound_of_node, front_to_back };

/// Regions of the group in one order for all rays; nodes are read first, then the blocks of those that may improve.
void in_group(const Field& field, const Group& group, const std::vector<Shared>& nodes,
              const std::vector<Shared>& blocks, Order order, std::vector<Best>& best, Work& work) {
  const auto comes_first = [&](const Shared& a, const Shared& b) {
    if (order != Order::front_to_back && a.bound != b.bound) return a.bound > b.bound;
    return a.nearest < b.nearest;
  };
  const auto sorted = [&](const std::vector<Shared>& regions) {
    std::vector<const Shared*> result;
    for (const Shared& region : regions) result.push_back(&region);
    std::stable_sort(result.begin(), result.end(), [&](auto* a, auto* b) { return comes_first(*a, *b); });
    return result;
  };
  const auto is_in = [](const Shared& block, const Shared& node) {
    return block.cell.x / 4 == node.cell.x && block.cell.y / 4 == node.cell.y && block.cell.z / 4 == node.cell.z;
  };
  work.regions += static_cast<double>(nodes.size());
  const std::vector<const Shared*> in_order = sorted(blocks);
  if (order == Order::bound) {  // as a queue would: a node comes before its blocks
    std::vector<bool> is_read(nodes.size());
    for (const Shared* block : in_order) {
      if (!any_may_improve(*block, best)) continue;
      for (std::size_t n = 0; n < nodes.size(); ++n)
        if (!is_read[n] && nodes[n].bound >= block->bound && any_may_improve(nodes[n], best)) {
          is_read[n] = true;
          work.regions += static_cast<double>(
              std::count_if(blocks.begin(), blocks.end(), [&](const Shared& b) { return is_in(b, nodes[n]); }));
        }
      open(field, group, *block, best, work);
    }
    return;
  }
  for (const Shared* node : sorted(nodes)) {
    if (!any_may_improve(*node, best)) continue;
    for (const Shared* block : in_order) {
      if (!is_in(*block, *node)) continue;
      ++work.regions;
      if (any_may_improve(*block, best)) open(field, group, *block, best, work);
    }
  }
}

/// For each ray first the block with the largest bound among those it passes.
void dive(const Field& field, const Group& group, const std::vector<Shared>& blocks, std::vector<Best>& best,
          Work& work) {
  std::vector<std::pair<const Shared*, const Passage*>> highest(group.rays.size());
  for (const Shared& block : blocks)
    for (const auto& [ray, at] : block.rays)
      if (!highest[ray].first || highest[ray].second->bound < at.bound) highest[ray] = {&block, &at};
  for (std::size_t r = 0; r < group.rays.size(); ++r)
    if (highest[r].first && best[r].may_improve(highest[r].second->bound, highest[r].second->t_in)) {
      ++work.blocks;
      look_into_block(field, group.rays[r], *highest[r].second, best[r], work);
    }
}

// ---- the study

struct View {
  const char* name;
  Vec3 towards;
  double zoom;    ///< share of the volume's diagonal that the picture's side shows
  double eye_at;  ///< distance of the eye from the middle, diagonals
};
constexpr View views[] = {{"front", {0.02, 1, 0.03}, 0.9, 2},
                          {"oblique", {0.5, 0.7, -0.4}, 0.9, 2},
                          {"close", {0.4, 0.8, 0.3}, 0.25, 2},
                          {"inside", {0.3, 0.9, -0.2}, 0.9, 0}};

/// 8 x 8 pixels of a picture of 1024 x 1024.
Group group_at(const Field& field, const View& view, int column, int row) {
  const Vec3 size = Vec3(field.samples - Index3(1)), middle = 0.5 * size;
  const double diagonal = size.length();
  const Vec3 forward = view.towards.normalized(), right = forward.cross(Vec3(0, 0, 1)).normalized(),
             up = right.cross(forward);
  const Vec3 eye = middle - view.eye_at * diagonal * forward;
  const double depth = std::max(view.eye_at, 0.5) * diagonal, side = view.zoom * diagonal;
  Group group;
  for (int p = 0; p < 64; ++p) {
    const double x = (column * 8 + p % 8 + 0.5) / 1024 - 0.5, y = (row * 8 + p / 8 + 0.5) / 1024 - 0.5;
    const Line ray{eye, (depth * forward + side * (x * right + y * up)).normalized()};
    if (const auto inside = clip(field, ray)) group.rays.push_back(ray), group.inside.push_back(*inside);
  }
  return group;
}

struct Row {
  const char* name;
  Work work;
};

class Study {
 public:
  explicit Study(const Field& field) : field_(field) {}

  /// One group, after its left neighbour.
  void add(const View& view, int column, int row) {
    const Group before = group_at(field_, view, column - 1, row), group = group_at(field_, view, column, row);
    if (group.rays.size() < 64 || before.rays.size() < 64) return;
    rays_ += 64;
    Work none;
    std::vector<Best> known_before(64), truth(64);
    for (std::size_t r = 0; r < 64; ++r)
      queue(field_, before.rays[r], before.inside[r].first, before.inside[r].second, known_before[r], none);
    for (std::size_t r = 0; r < 64; ++r)
      queue(field_, group.rays[r], group.inside[r].first, group.inside[r].second, truth[r], none);

    row_ = 0;
    const auto alone = [&](const char* name, auto search, auto first) {
      std::vector<Best> best(64);
      Work work;
      for (std::size_t r = 0; r < 64; ++r) {
        first(best, r);
        search(field_, group.rays[r], group.inside[r].first, group.inside[r].second, best[r], work);
      }
      finish(name, best, truth, work);
    };
    const auto none_first = [](std::vector<Best>&, std::size_t) {};
    const auto last_t = [&](std::vector<Best>& best, std::size_t r) {
      if (r > 0) guess(field_, group.rays[r], best[r - 1].t, best[r]);
    };
    const auto answer = [&](std::vector<Best>& best, std::size_t r) { best[r] = truth[r]; };
    alone("ray, queue", queue, none_first);
    alone("ray, queue, last t", queue, last_t);
    alone("ray, front to back", front_to_back, none_first);
    alone("ray, front to back, last t", front_to_back, last_t);
    alone("ray, front to back, the answer known", front_to_back, answer);

    const std::vector<Shared> nodes = shared_regions(field_, group, 2), blocks = shared_regions(field_, group, 1);
    const auto together = [&](const char* name, Order order, auto first, bool dives = false) {
      std::vector<Best> best(64);
      Work work;
      for (std::size_t r = 0; r < 64; ++r) first(best, r);
      if (dives) dive(field_, group, blocks, best, work);
      in_group(field_, group, nodes, blocks, order, best, work);
      finish(name, best, truth, work);
    };
    const auto neighbour_t = [&](std::vector<Best>& best, std::size_t r) {
      guess(field_, group.rays[r], known_before[r].t, best[r]);
      // The nearest column of the group before, too.
      guess(field_, group.rays[r], known_before[r / 8 * 8 + 7].t, best[r]);
    };
    together("group, largest bound first", Order::bound, none_first);
    together("group, largest bound first, neighbours' t", Order::bound, neighbour_t);
    together("group, nodes by bound", Order::bound_of_node, none_first);
    together("group, nodes by bound, neighbours' t", Order::bound_of_node, neighbour_t);
    together("group, front to back", Order::front_to_back, none_first);
    together("group, front to back, neighbours' t", Order::front_to_back, neighbour_t);
    together("group, front to back, each ray's highest block first", Order::front_to_back, none_first, true);
    together("group, front to back, both", Order::front_to_back, neighbour_t, true);
    together("group, front to back, the answer known", Order::front_to_back, answer);
  }

  std::vector<Json> rows(const char* view) const {
    std::vector<Json> result;
    for (const Row& row : rows_) {
      const auto per_ray = [&](double count) { return count / rays_; };
      result.push_back({{"view", view},
                        {"order", row.name},
                        {"regions", per_ray(row.work.regions)},
                        {"blocks_of_group", 64 * per_ray(row.work.blocks)},
                        {"in_blocks", per_ray(row.work.in_blocks)},
                        {"cells", per_ray(row.work.cells)},
                        {"cubics", per_ray(row.work.cubics)},
                        {"solved", per_ray(row.work.solved)}});
    }
    return result;
  }
  double rays() const { return rays_; }
  std::uint64_t wrong() const { return wrong_; }

 private:
  void finish(const char* name, const std::vector<Best>& best, const std::vector<Best>& truth, const Work& work) {
    for (std::size_t r = 0; r < 64; ++r)
      wrong_ += !(std::abs(best[r].value - truth[r].value) <= 1e-6 * std::max(1.0, std::abs(truth[r].value)));
    if (rows_.size() <= row_) rows_.push_back({name, {}});
    rows_[row_++].work.add(work);
  }

  const Field& field_;
  double rays_ = 0;
  std::uint64_t wrong_ = 0;
  std::size_t row_ = 0;
  std::vector<Row> rows_;
};

int run(const Wishes& wishes) {
  require_publishable(wishes.common, {"maximum_search"});
  const Field field = load(wishes.file);
  tools::Table table{"maximum_search", "What the search for the largest value looks at, per ray", {}, {}};
  std::uint64_t wrong = 0;
  for (const View& view : views) {
    Study study(field);
    // Evenly over the picture.
    const int stride = std::max(1, static_cast<int>(std::sqrt(128.0 * 128.0 / static_cast<double>(wishes.groups))));
    for (int row = stride / 2; row < 128; row += stride)
      for (int column = 1 + stride / 2; column < 128; column += stride) study.add(view, column, row);
    for (const Json& row : study.rows(view.name)) table.rows.push_back(row);
    wrong += study.wrong();
  }
  table.context =
      context_with({{"file", wishes.file.filename().string()}, {"groups", wishes.groups}, {"wrong", wrong}});
  publish(table, wishes.common);
  return wrong == 0 ? 0 : static_cast<int>(Trouble::outside_limit);
}

}  // namespace

tools::Subcommand maximum_search() {
  const auto wishes = std::make_shared<Wishes>();
  return {
      .name = "maximum-search",
      .summary = "In which order to look for the largest value along rays: what each order looks at",
      .examples = "  rhoray-study maximum-search head.rho -o results\n",
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid (.rho)", wishes->file)},
           tools::output_options(wishes->common, "FOLDER for maximum_search.csv and .json"),
           {tools::value_option("--groups", "N", "Groups of 8 x 8 rays of each view; default 400", wishes->groups)}}),
      .run = [wishes] { return run(*wishes); }};
}

}  // namespace rhoray::study
