#include "preprocess/import/reading/hdf5_file.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

using formats::ElementType;

/// An identifier of the library, closed at the end.
class Hdf5DataSet::Handle {
 public:
  using Close = herr_t(hid_t);
  Handle(hid_t id, Close* close) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  hid_t id() const { return id_; }
  bool is_open() const { return id_ >= 0; }

 private:
  hid_t id_;
  Close* close_;
};

namespace {

/// Called for a link to another file: a negative number forbids to follow it.
herr_t follow_no_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) {
  return -1;
}

bool is_outside(hid_t creation) {
  return H5Pget_layout(creation) == H5D_VIRTUAL || H5Pget_external_count(creation) != 0;
}

/// Whether the file has a value of its own for numbers that were not written.
bool has_fill_value(hid_t creation) {
  H5D_fill_value_t kind = H5D_FILL_VALUE_UNDEFINED;
  H5D_fill_time_t time = H5D_FILL_TIME_NEVER;
  return H5Pfill_value_defined(creation, &kind) >= 0 && kind == H5D_FILL_VALUE_USER_DEFINED &&
         H5Pget_fill_time(creation, &time) >= 0 && time != H5D_FILL_TIME_NEVER;
}

using Sizes = std::array<hsize_t, H5S_MAX_RANK>;

/// The sizes of a data set along its axes; nothing if it has none.
std::optional<std::span<const hsize_t>> shape_of(hid_t data_set, Sizes& sizes) {
  const hid_t space = H5Dget_space(data_set);
  const int axes = space < 0 ? -1 : H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  if (space >= 0) H5Sclose(space);
  return axes < 0 ? std::nullopt : std::optional(std::span<const hsize_t>(sizes).first(static_cast<std::size_t>(axes)));
}

/// The chunks along one axis that hold indices of a part.
std::vector<hsize_t> chunks_of(const Hyperslab& part, std::size_t axis, hsize_t size, hsize_t chunk) {
  std::vector<hsize_t> chunks;
  for (std::uint64_t i = 0, at = part.start[axis]; i < part.count[axis] && at < size; ++i, at += part.stride[axis])
    if (chunks.empty() || chunks.back() != at / chunk) chunks.push_back(at / chunk);
  return chunks;
}

/// Whether the file stores every chunk that holds numbers of a part.
bool stores(hid_t data_set, const Hyperslab& part, std::span<const hsize_t> shape, std::span<const hsize_t> chunk) {
  std::vector<std::vector<hsize_t>> along;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    along.push_back(chunks_of(part, axis, shape[axis], chunk[axis]));
    if (along.back().empty()) return true;
  }
  std::vector<std::size_t> at(shape.size(), 0);
  std::vector<hsize_t> first(shape.size());
  for (;;) {
    for (std::size_t axis = 0; axis < at.size(); ++axis) first[axis] = along[axis][at[axis]] * chunk[axis];
    unsigned filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    if (H5Dget_chunk_info_by_coord(data_set, first.data(), &filters, &address, &bytes) < 0 || address == HADDR_UNDEF)
      return false;
    std::size_t axis = 0;
    while (axis < at.size() && ++at[axis] == along[axis].size()) at[axis++] = 0;
    if (axis == at.size()) return true;
  }
}

/// The first link or data set that leads to another file.
struct Outside {
  std::string name;
  bool is_link = false;
};

herr_t find_outside(hid_t group, const char* name, const H5L_info_t* link, void* data) {
  Outside& outside = *static_cast<Outside*>(data);
  if (link->type == H5L_TYPE_SOFT) return 0;  // its object has another link, or is not in this file
  outside.name = name;
  outside.is_link = link->type != H5L_TYPE_HARD;
  if (outside.is_link) return 1;
  const Hdf5DataSet::Handle object(H5Oopen(group, name, H5P_DEFAULT), H5Oclose);
  if (H5Iget_type(object.id()) != H5I_DATASET) return 0;
  const Hdf5DataSet::Handle creation(H5Dget_create_plist(object.id()), H5Pclose);
  return creation.is_open() && is_outside(creation.id()) ? 1 : 0;
}

std::optional<ElementType> element_type_of(hid_t type) {
  const std::size_t bytes = H5Tget_size(type);
  if (H5Tget_class(type) == H5T_FLOAT) {
    if (bytes == 2 || bytes == 4) return ElementType::F32;
    return bytes == 8 ? std::optional(ElementType::F64) : std::nullopt;
  }
  if (H5Tget_class(type) != H5T_INTEGER) return std::nullopt;
  const bool is_signed = H5Tget_sign(type) == H5T_SGN_2;
  switch (bytes) {
    case 1:
      return is_signed ? ElementType::I8 : ElementType::U8;
    case 2:
      return is_signed ? ElementType::I16 : ElementType::U16;
    case 4:
      return is_signed ? ElementType::I32 : ElementType::U32;
    case 8:
      return is_signed ? ElementType::I64 : ElementType::U64;
    default:
      return std::nullopt;
  }
}

hid_t native_type(ElementType type) {
  switch (type) {
    case ElementType::U8:
      return H5T_NATIVE_UINT8;
    case ElementType::I8:
      return H5T_NATIVE_INT8;
    case ElementType::U16:
      return H5T_NATIVE_UINT16;
    case ElementType::I16:
      return H5T_NATIVE_INT16;
    case ElementType::U32:
      return H5T_NATIVE_UINT32;
    case ElementType::I32:
      return H5T_NATIVE_INT32;
    case ElementType::U64:
      return H5T_NATIVE_UINT64;
    case ElementType::I64:
      return H5T_NATIVE_INT64;
    case ElementType::F32:
      return H5T_NATIVE_FLOAT;
    case ElementType::F64:
      break;
  }
  return H5T_NATIVE_DOUBLE;
}

/// See Hdf5File::check_written.
void check_written(const std::filesystem::path& path, const std::string& name, hid_t data_set, const Hyperslab* part) {
  const Hdf5DataSet::Handle creation(H5Dget_create_plist(data_set), H5Pclose);
  Sizes sizes{}, chunk_sizes{};
  const auto shape = shape_of(data_set, sizes);
  if (!creation.is_open() || !shape || std::find(shape->begin(), shape->end(), 0) != shape->end()) return;
  const auto refuse = [&](const std::string& found, const char* expected) {
    refuse_input(path, concat("data set ", in_quotes(name)), found, expected);
  };
  const H5D_layout_t layout = H5Pget_layout(creation.id());
  if (layout == H5D_COMPACT || has_fill_value(creation.id())) return;
  if (layout == H5D_CONTIGUOUS && H5Dget_storage_size(data_set) == 0)
    refuse("no numbers: they were never written", "numbers");
  if (layout != H5D_CHUNKED) return;
  H5Pget_chunk(creation.id(), static_cast<int>(shape->size()), chunk_sizes.data());
  const auto chunk = std::span<const hsize_t>(chunk_sizes).first(shape->size());
  std::optional<std::uint64_t> wanted = 1;
  for (std::size_t axis = 0; axis < shape->size() && wanted; ++axis)
    wanted = checked_product({*wanted, ((*shape)[axis] - 1) / chunk[axis] + 1});
  hsize_t stored = 0;
  const Hdf5DataSet::Handle space(H5Dget_space(data_set), H5Sclose);
  if (H5Dget_num_chunks(data_set, space.id(), &stored) < 0) refuse("a damaged index of chunks", "a whole one");
  if (wanted && stored >= *wanted) return;
  if (part == nullptr)
    refuse(concat(stored, " of ", wanted ? concat(*wanted) : "very many", " chunks"),
           "all: the others were never written");
  if (!stores(data_set, *part, *shape, chunk)) refuse("a part without numbers: they were never written", "numbers");
}

template <class T>
hid_t memory_type(ElementType type) {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  return native_type(type);
}

}  // namespace

void Hdf5DataSet::refuse(std::string_view found, std::string_view expected, ErrorCode error_code) const {
  refuse_input(path_, concat("data set ", in_quotes(name_)), found, expected, error_code);
}

void Hdf5DataSet::check_bytes(std::uint64_t wanted) const {
  if (wanted > 0 && stored_bytes_ == 0) refuse("no numbers: they were never written", concat(wanted, " bytes"));
  if (!is_packed_ && stored_bytes_ < wanted) refuse(concat(stored_bytes_, " bytes"), concat(wanted));
  check_packed_size(path_, wanted, stored_bytes_);
}

template <class T>
void Hdf5DataSet::read(std::span<T> to, const Hyperslab* part) const {
  if (to.empty()) return;
  check_written(path_, name_, data_set_->id(), part);
  const Handle in_file(H5Dget_space(data_set_->id()), H5Sclose);
  hid_t in_memory = H5S_ALL;
  std::optional<Handle> space;
  if (part != nullptr) {
    const auto all = [](const std::vector<std::uint64_t>& numbers) {
      return std::vector<hsize_t>(numbers.begin(), numbers.end());
    };
    const auto start = all(part->start), stride = all(part->stride), count = all(part->count);
    if (H5Sselect_hyperslab(in_file.id(), H5S_SELECT_SET, start.data(), stride.data(), count.data(), nullptr) < 0)
      refuse("no such part", "a part inside it");
    in_memory = space.emplace(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose).id();
  }
  if (H5Dread(data_set_->id(), memory_type<T>(type_), in_memory, in_file.id(), H5P_DEFAULT, to.data()) < 0)
    refuse("damaged data, or a compression that is not known here", "numbers that can be read");
}

template void Hdf5DataSet::read(std::span<double>, const Hyperslab*) const;
template void Hdf5DataSet::read(std::span<std::int64_t>, const Hyperslab*) const;
template void Hdf5DataSet::read(std::span<std::byte>, const Hyperslab*) const;

Hdf5File::Hdf5File(const std::filesystem::path& path, Driver driver) : path_(path) {
  bytes_ = ForeignFile(path).bytes().size();  // a file, and noted
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Hdf5DataSet::Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  driver == Driver::buffered ? H5Pset_fapl_stdio(access.id()) : H5Pset_fapl_sec2(access.id());
  H5Pset_file_locking(access.id(), true, true);  // where the file system has locks
  const std::string name = std::filesystem::absolute(path).string();
  file_ = std::make_shared<Hdf5DataSet::Handle>(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (!file_->is_open()) refuse_input(path, "header", "damaged data, or another format", "a whole file of HDF5");
}

bool Hdf5File::is_hdf5(const std::filesystem::path& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  return H5Fis_hdf5(std::filesystem::absolute(path).c_str()) > 0;
}

void Hdf5File::check_links() const {
  Outside outside;
  if (H5Lvisit(file_->id(), H5_INDEX_NAME, H5_ITER_NATIVE, find_outside, &outside) <= 0) return;
  refuse_input(path_, concat(outside.is_link ? "link " : "data set ", in_quotes(outside.name)),
               outside.is_link ? "one to another file" : "numbers in other files",
               outside.is_link ? "links inside this file" : "numbers in this file", ErrorCode::unsupported);
}

void Hdf5File::check_written(const std::string& name, const Hyperslab* part) const {
  const Hdf5DataSet::Handle data_set(H5Dopen2(file_->id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (data_set.is_open()) preprocess::check_written(path_, name, data_set.id(), part);
}

Hdf5DataSet Hdf5File::data_set(const std::string& name) const {
  Hdf5DataSet result;
  result.path_ = path_;
  result.name_ = name;
  result.file_ = file_;
  const Hdf5DataSet::Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_elink_cb(access.id(), follow_no_link, nullptr);
  result.data_set_ = std::make_shared<Hdf5DataSet::Handle>(H5Dopen2(file_->id(), name.c_str(), access.id()), H5Dclose);
  const hid_t id = result.data_set_->id();
  if (id < 0) result.refuse("none, or a link out of the file", "one of this name");
  const Hdf5DataSet::Handle creation(H5Dget_create_plist(id), H5Pclose), type(H5Dget_type(id), H5Tclose);
  if (!creation.is_open() || !type.is_open()) result.refuse("a damaged header", "a whole one");
  if (is_outside(creation.id()))
    result.refuse("numbers in other files", "numbers in this file", ErrorCode::unsupported);
  const std::optional<ElementType> element_type = element_type_of(type.id());
  if (!element_type) result.refuse("other data", "integers, or floats of 16, 32 or 64 bits", ErrorCode::unsupported);
  result.type_ = *element_type;
  Sizes sizes{};
  const auto shape = shape_of(id, sizes);
  if (!shape) result.refuse("no extent", "sizes along its axes");
  result.shape_.assign(shape->begin(), shape->end());
  result.is_packed_ = H5Pget_nfilters(creation.id()) != 0 || has_fill_value(creation.id());
  result.stored_bytes_ = std::min<std::uint64_t>(H5Dget_storage_size(id), bytes_);
  return result;
}

}  // namespace rhoray::preprocess
