#include "preprocess/labels.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <mutex>
#include <system_error>
#include <type_traits>

#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "preprocess/pack_volume.h"

namespace rhoray::preprocess {

namespace {

using formats::BrickGrid;

/// The labels of some rows, and how often neighbours along them differ.
struct Found {
  std::vector<Label> labels;  ///< 0 among them
  std::uint64_t pairs = 0;    ///< of neighbours that are not both 0
  std::uint64_t changes = 0;

  bool has_too_many() const { return labels.size() > most_labels + 1; }

  /// Includes a box of samples.
  void include(const Label& one) {
    const auto known = std::find_if(labels.begin(), labels.end(), [&](const Label& l) { return l.value == one.value; });
    if (known == labels.end()) {
      labels.push_back(one);
      return;
    }
    for (int axis = 0; axis < 3; ++axis) {
      known->first[axis] = std::min(known->first[axis], one.first[axis]);
      known->end[axis] = std::max(known->end[axis], one.end[axis]);
    }
  }

  void include(const Found& other) {
    for (const Label& label : other.labels) include(label);
    pairs += other.pairs, changes += other.changes;
  }
};

/// True for a field of integers whose histogram has few values.
bool may_be_labels(const formats::FieldSummary& field) {
  if (field.type == formats::ElementType::F32 || field.type == formats::ElementType::F64) return false;
  if (field.range.is_empty() || field.range.lo < std::numeric_limits<int>::min() ||
      field.range.hi > std::numeric_limits<int>::max())
    return false;
  const auto used = std::count_if(field.histogram.begin(), field.histogram.end(), [](auto count) { return count > 0; });
  return used > 2 && static_cast<std::size_t>(used) <= most_labels + 1;
}

template <class T>
void scan_row(const BrickGrid& grid, std::span<const T> samples, std::int64_t j, std::int64_t k, Found& found) {
  const Index3& count = grid.description().layout.sample_count;
  const auto at = [&](std::int64_t i) { return samples[grid.tables().address(i, j, k)]; };
  for (std::int64_t begin = 0, end; begin < count.x; begin = end) {
    const T value = at(begin);
    for (end = begin + 1; end < count.x && at(end) == value;) ++end;
    found.include({static_cast<int>(value), {begin, j, k}, {end, j + 1, k + 1}});
    if (found.has_too_many()) return;
    if (value != 0) found.pairs += static_cast<std::uint64_t>(end - begin - 1);
    if (end < count.x) ++found.pairs, ++found.changes;
  }
}

template <class T>
Found scan(const BrickGrid& grid, std::size_t field) {
  const Index3& count = grid.description().layout.sample_count;
  const std::span<const T> samples = grid.samples<T>(field);
  Found all;
  std::mutex guard;
  for_each_range(static_cast<std::uint64_t>(count.z), 4, 0, [&](std::uint64_t first, std::uint64_t end) {
    Found found;
    for (auto k = static_cast<std::int64_t>(first); k < static_cast<std::int64_t>(end); ++k)
      for (std::int64_t j = 0; j < count.y && !found.has_too_many(); ++j) scan_row(grid, samples, j, k, found);
    const std::lock_guard lock(guard);
    all.include(found);
  });
  return all;
}

/// The samples of the indicator, x fastest.
template <class T>
Array<std::byte> indicator(const BrickGrid& grid, std::size_t field, int value, const Index3& first,
                           const Index3& count) {
  const std::span<const T> samples = grid.samples<T>(field);
  Array<std::byte> out(static_cast<std::size_t>(volume(count)));
  for_each_range(static_cast<std::uint64_t>(count.z), 4, 0, [&](std::uint64_t from, std::uint64_t to) {
    for (auto k = static_cast<std::int64_t>(from); k < static_cast<std::int64_t>(to); ++k)
      for (std::int64_t j = 0; j < count.y; ++j)
        for (std::int64_t i = 0; i < count.x; ++i) {
          const T sample = samples[grid.tables().address(first.x + i, first.y + j, first.z + k)];
          out[static_cast<std::size_t>((k * count.y + j) * count.x + i)] =
              std::byte{static_cast<std::int64_t>(sample) == value};
        }
  });
  return out;
}

}  // namespace

std::optional<std::vector<Label>> find_labels(const BrickGrid& grid, std::size_t field) {
  const formats::GridDescription& description = grid.description();
  if (description.layout.is_sparse || !may_be_labels(description.fields[field])) return std::nullopt;
  Found found = formats::with_element_type(description.fields[field].type, [&]<class T>(T) {
    if constexpr (std::is_floating_point_v<T>)
      return Found{};
    else
      return scan<T>(grid, field);
  });
  std::erase_if(found.labels, [](const Label& label) { return label.value == 0; });
  constexpr double most_changes = 0.3;
  if (found.labels.size() < 2 || found.labels.size() > most_labels ||
      static_cast<double>(found.changes) > most_changes * static_cast<double>(found.pairs))
    return std::nullopt;
  std::sort(found.labels.begin(), found.labels.end(), [](const Label& a, const Label& b) { return a.value < b.value; });
  return std::move(found.labels);
}

formats::PackedFile pack_indicator(const BrickGrid& grid, std::size_t field, const Label& label) {
  const formats::GridDescription& description = grid.description();
  Index3 first, end, count;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = std::max<std::int64_t>(label.first[axis] - 1, 0);
    end[axis] = std::min(label.end[axis] + 1, description.layout.sample_count[axis]);
    count[axis] = end[axis] - first[axis];
  }
  NeutralVolume packed;
  packed.sample_count = count;
  packed.type = formats::ElementType::U8;
  packed.owned_samples = formats::with_element_type(
      description.fields[field].type, [&]<class T>(T) { return indicator<T>(grid, field, label.value, first, count); });
  packed.samples = packed.owned_samples;
  Vec3 corner(0, 0, 0);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& table = description.axes[static_cast<std::size_t>(axis)];
    if (table.empty())
      corner[axis] = static_cast<double>(first[axis]);
    else
      packed.axes[static_cast<std::size_t>(axis)].assign(table.begin() + first[axis], table.begin() + end[axis]);
  }
  packed.world_from_grid = description.world_from_grid;
  packed.world_from_grid.origin = description.world_from_grid.point(corner);
  packed.length_unit = description.length_unit;
  packed.space = description.space;
  packed.field_name = concat("label ", label.value);
  const formats::LabelNames& names = description.fields[field].label_names;
  if (const auto name = names.find(label.value); name != names.end()) packed.label_names[1] = name->second;

  const Descriptor memory(::memfd_create("rhoray-label", MFD_CLOEXEC));
  if (memory.number() < 0)
    throw Error(ErrorCode::resource,
                concat(grid.file().name(), ": memfd_create: ", std::system_category().message(errno)));
  pack_volume(packed, formats::Destination(memory.number()), {.source_name = grid.file().name()});
  return formats::PackedFile::from_descriptor(memory.number(), grid.file().name());
}

}  // namespace rhoray::preprocess
