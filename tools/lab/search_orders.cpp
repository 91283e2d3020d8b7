#include "tools/lab/search_orders.h"

#include <algorithm>
#include <cmath>

namespace rhoray::study {
namespace {

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

/// Computes the largest value in a cell. Evaluates the critical points of the cubic only if its
/// control points exceed the best value so far.
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

}  // namespace

void guess(const Field& field, const Line& ray, double t, Best& best) {
  Index3 cell;
  for (int a = 0; a < 3; ++a)
    cell[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(ray.origin[a] + t * ray.direction[a])), 0,
                                       field.levels[0].count[a] - 1);
  const double value = at_point(field, cell, in_cell(ray, cell, t));
  best.offer(value - 1e-9 * std::abs(value), std::numeric_limits<double>::infinity());
}

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

namespace {

bool any_may_improve(const Shared& region, const std::vector<Best>& best) {
  return std::any_of(region.rays.begin(), region.rays.end(),
                     [&](const auto& at) { return best[at.first].may_improve(at.second.bound, at.second.t_in); });
}

void open(const Field& field, const Group& group, const Shared& block, std::vector<Best>& best, Work& work) {
  ++work.blocks;
  for (const auto& [ray, at] : block.rays)
    if (best[ray].may_improve(at.bound, at.t_in)) look_into_block(field, group.rays[ray], at, best[ray], work);
}

}  // namespace

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
  if (order == Order::bound) {  // as in a queue: a node comes before its blocks
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

}  // namespace rhoray::study
