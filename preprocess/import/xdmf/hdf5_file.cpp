#include "preprocess/import/xdmf/hdf5_file.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>

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
  check_packed_size(path_, wanted, stored_bytes_);
}

template <class T>
void Hdf5DataSet::read(std::span<T> to, const Hyperslab* part) const {
  if (to.empty()) return;
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

Hdf5File::Hdf5File(const std::filesystem::path& path) : path_(path) {
  bytes_ = ForeignFile(path).bytes().size();  // a file, and noted
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Hdf5DataSet::Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_sec2(access.id());
  H5Pset_file_locking(access.id(), true, true);  // where the file system has locks
  const std::string name = std::filesystem::absolute(path).string();
  file_ = std::make_shared<Hdf5DataSet::Handle>(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (!file_->is_open()) refuse_input(path, "header", "damaged data, or another format", "a whole file of HDF5");
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
  const Hdf5DataSet::Handle creation(H5Dget_create_plist(id), H5Pclose), type(H5Dget_type(id), H5Tclose),
      space(H5Dget_space(id), H5Sclose);
  if (!creation.is_open() || !type.is_open() || !space.is_open()) result.refuse("a damaged header", "a whole one");
  if (H5Pget_layout(creation.id()) == H5D_VIRTUAL || H5Pget_external_count(creation.id()) != 0)
    result.refuse("numbers in other files", "numbers in this file", ErrorCode::unsupported);
  const std::optional<ElementType> element_type = element_type_of(type.id());
  if (!element_type) result.refuse("other data", "integers, or floats of 16, 32 or 64 bits", ErrorCode::unsupported);
  result.type_ = *element_type;
  std::array<hsize_t, H5S_MAX_RANK> sizes{};
  const int axes = H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr);
  if (axes < 0) result.refuse("no extent", "sizes along its axes");
  result.shape_.assign(sizes.begin(), sizes.begin() + axes);
  result.stored_bytes_ = std::min<std::uint64_t>(H5Dget_storage_size(id), bytes_);
  return result;
}

}  // namespace rhoray::preprocess
