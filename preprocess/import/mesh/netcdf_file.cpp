#include "preprocess/import/mesh/netcdf_file.h"

#include <netcdf.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "formats/base/bytes.h"
#include "preprocess/import/mesh/netcdf_classic.h"
#include "preprocess/import/reading/samples.h"

namespace rhoray::preprocess {
namespace {

// Largest expansion of Deflate, in bytes out per byte in. It is the strongest compression that
// netCDF-4 files commonly use.
constexpr std::uint64_t largest_expansion = 1032;

std::string text_of(std::span<const std::uint64_t> shape) {
  std::string text;
  for (const std::uint64_t size : shape) text += concat(text.empty() ? "" : " x ", size);
  return text.empty() ? "one number" : text;
}

/// The element type of a nc_type; nothing for texts and other types.
std::optional<formats::ElementType> element_type_of(int nc_type_number) {
  using formats::ElementType;
  static constexpr std::pair<int, ElementType> types[] = {{NC_BYTE, ElementType::I8},   {NC_UBYTE, ElementType::U8},
                                                          {NC_SHORT, ElementType::I16}, {NC_USHORT, ElementType::U16},
                                                          {NC_INT, ElementType::I32},   {NC_UINT, ElementType::U32},
                                                          {NC_INT64, ElementType::I64}, {NC_UINT64, ElementType::U64},
                                                          {NC_FLOAT, ElementType::F32}, {NC_DOUBLE, ElementType::F64}};
  return find_in(types, nc_type_number);
}

}  // namespace

NetcdfFile::NetcdfFile(const std::filesystem::path& path) : path_(path) {
  const ForeignFile file(path);
  check_classic_netcdf(file);
  file_bytes_ = file.bytes().size();
  // before netCDF's library opens it: that follows links to other files
  if (Hdf5File::is_hdf5(path)) hdf5_.emplace(path, Hdf5File::Driver::buffered).check_links();
  // An absolute name cannot be mistaken for a network address.
  check(::nc_open(std::filesystem::absolute(path).c_str(), NC_NOWRITE, &id_), "header");
}

NetcdfFile::~NetcdfFile() {
  ::nc_close(id_);
}

void NetcdfFile::check(int status, std::string_view place) const {
  if (status == NC_NOERR) return;
  if (status == NC_ENOMEM) throw Error(ErrorCode::resource, concat(path_.string(), ", ", place, ": out of memory"));
  refuse_input(path_, place, "damaged data, or another format", "a whole file of netCDF or HDF5");
}

std::optional<std::uint64_t> NetcdfFile::dimension(const std::string& name) const {
  int id = 0;
  std::size_t size = 0;
  if (::nc_inq_dimid(id_, name.c_str(), &id) != NC_NOERR) return std::nullopt;
  check(::nc_inq_dimlen(id_, id, &size), name);
  return size;
}

std::optional<NetcdfFile::Variable> NetcdfFile::variable(const std::string& name) const {
  const std::size_t slash = name.rfind('/');
  const std::optional<int> group = slash == std::string::npos ? std::optional(id_) : group_id(name.substr(0, slash));
  Variable result;
  result.name = name;
  result.group = group.value_or(id_);
  const std::string own_name = name.substr(slash == std::string::npos ? 0 : slash + 1);
  if (!group || ::nc_inq_varid(*group, own_name.c_str(), &result.id) != NC_NOERR) return std::nullopt;
  int axes = 0;
  check(::nc_inq_vartype(*group, result.id, &result.type), name);
  check(::nc_inq_varndims(*group, result.id, &axes), name);
  std::vector<int> dimensions(static_cast<std::size_t>(axes));
  check(::nc_inq_vardimid(*group, result.id, dimensions.data()), name);
  for (const int dimension : dimensions) {
    std::size_t size = 0;
    check(::nc_inq_dimlen(*group, dimension, &size), name);
    result.shape.push_back(size);
  }
  return result;
}

NetcdfFile::Variable NetcdfFile::need_variable(const std::string& name) const {
  const std::optional<Variable> found = variable(name);
  if (!found) refuse_input(path_, "variables", concat("no '", name, "'"), "one of this name");
  return *found;
}

std::uint64_t NetcdfFile::checked_count(const Variable& variable, std::span<const std::uint64_t> shape,
                                        bool is_part) const {
  const std::span<const std::uint64_t> found = std::span(variable.shape).subspan(is_part && !variable.shape.empty());
  if (!std::equal(found.begin(), found.end(), shape.begin(), shape.end()))
    refuse_input(path_, concat("variable '", variable.name, "'"), text_of(found), text_of(shape));
  std::optional<std::uint64_t> count = 1;
  for (const std::uint64_t size : shape)
    if (count) count = checked_product({*count, size});
  if (!count || *count / largest_expansion > file_bytes_)
    refuse_input(path_, concat("variable '", variable.name, "'"),
                 concat(text_of(shape), " numbers in a file of ", file_bytes_, " bytes"), "what the file can hold");
  return *count;
}

void NetcdfFile::check_written(const Variable& variable, std::optional<std::uint64_t> first) const {
  if (!hdf5_ || (first && variable.shape.empty())) return;
  Hyperslab part{.start = std::vector<std::uint64_t>(variable.shape.size(), 0),
                 .stride = std::vector<std::uint64_t>(variable.shape.size(), 1),
                 .count = variable.shape};
  if (first) {
    part.start.front() = *first;
    part.count.front() = 1;
  }
  const std::size_t own_name = variable.name.rfind('/') + 1;
  // netCDF's library adds this to the name of a variable that shares it with a dimension
  for (const char* beginning : {"", "_nc4_non_coord_"})
    hdf5_->check_written(concat(variable.name.substr(0, own_name), beginning, variable.name.substr(own_name)),
                         first ? &part : nullptr);
}

Array<double> NetcdfFile::numbers(const Variable& variable, std::span<const std::uint64_t> shape,
                                  std::optional<std::uint64_t> first) const {
  Array<double> result(checked_count(variable, shape, first.has_value()));
  check_written(variable, first);
  std::vector<std::size_t> start(variable.shape.size(), 0), count(variable.shape.begin(), variable.shape.end());
  if (first) {
    start.front() = *first;
    count.front() = 1;
  }
  if (!result.empty())
    check(::nc_get_vara_double(variable.group, variable.id, start.data(), count.data(), result.data()), variable.name);
  return result;
}

Array<std::int64_t> NetcdfFile::integers(const Variable& variable, std::span<const std::uint64_t> shape) const {
  static_assert(sizeof(long long) == sizeof(std::int64_t));
  Array<std::int64_t> result(checked_count(variable, shape, false));
  if (variable.type == NC_FLOAT || variable.type == NC_DOUBLE)
    refuse_input(path_, concat("variable '", variable.name, "'"), "floating-point numbers", "integers");
  check_written(variable);
  if (!result.empty())
    check(::nc_get_var_longlong(variable.group, variable.id, reinterpret_cast<long long*>(result.data())),
          variable.name);
  return result;
}

std::vector<std::string> NetcdfFile::texts(const Variable& variable) const {
  if (variable.type != NC_CHAR || variable.shape.size() != 2 || variable.shape[1] == 0)
    refuse_input(path_, concat("variable '", variable.name, "'"), text_of(variable.shape),
                 "a table of letters, one name in each row");
  const std::uint64_t length = variable.shape[1];
  std::string letters(checked_count(variable, variable.shape, false), '\0');
  if (!letters.empty()) check(::nc_get_var_text(variable.group, variable.id, letters.data()), variable.name);
  std::vector<std::string> result;
  for (std::uint64_t row = 0; row < variable.shape[0]; ++row) {
    std::string text = letters.substr(row * length, length);
    text.resize(std::min(text.find('\0'), text.size()));
    text.resize(text.find_last_not_of(" \t") + 1);
    result.push_back(std::move(text));
  }
  return result;
}

std::string NetcdfFile::text_attribute(int group, int variable, const std::string& name, std::string_view place) const {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (::nc_inq_att(group, variable, name.c_str(), &type, &length) != NC_NOERR) return {};
  std::string text;
  if (type == NC_STRING && length == 1) {
    char* letters = nullptr;
    check(::nc_get_att_string(group, variable, name.c_str(), &letters), place);
    if (letters != nullptr) text = letters;
    ::nc_free_string(1, &letters);
  } else if (type == NC_CHAR && length > 0) {
    text.resize(length);
    check(::nc_get_att_text(group, variable, name.c_str(), text.data()), place);
  }
  text.resize(std::min(text.find('\0'), text.size()));
  text.resize(text.find_last_not_of(" \t") + 1);
  return text;
}

std::string NetcdfFile::text_attribute(const Variable& variable, const std::string& name) const {
  return text_attribute(variable.group, variable.id, name, variable.name);
}

std::string NetcdfFile::text_attribute(const std::string& group, const std::string& name) const {
  const std::optional<int> id = group_id(group);
  return id ? text_attribute(*id, NC_GLOBAL, name, group) : std::string();
}

std::optional<int> NetcdfFile::group_id(const std::string& group) const {
  int id = 0;
  if (::nc_inq_grp_full_ncid(id_, concat("/", group).c_str(), &id) != NC_NOERR) return std::nullopt;
  return id;
}

bool NetcdfFile::has_group(const std::string& group) const {
  return group_id(group).has_value();
}

std::vector<std::string> NetcdfFile::names_in(const std::string& group) const {
  const std::optional<int> id = group_id(group);
  if (!id) return {};
  int count = 0;
  check(::nc_inq_varids(*id, &count, nullptr), group);
  std::vector<int> variables(static_cast<std::size_t>(count));
  check(::nc_inq_varids(*id, &count, variables.data()), group);
  std::vector<std::string> names;
  for (const int variable : variables) {
    std::array<char, NC_MAX_NAME + 1> name{};
    check(::nc_inq_varname(*id, variable, name.data()), group);
    names.emplace_back(name.data());
  }
  return names;
}

std::vector<double> NetcdfFile::number_attribute(const std::string& group, const std::string& name) const {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  constexpr std::size_t most = 1024;
  const std::optional<int> id = group_id(group);
  if (!id || ::nc_inq_att(*id, NC_GLOBAL, name.c_str(), &type, &length) != NC_NOERR) return {};
  if (!element_type_of(type) || length == 0 || length > most) return {};
  std::vector<double> numbers(length);
  check(::nc_get_att_double(*id, NC_GLOBAL, name.c_str(), numbers.data()), concat("attribute ", name));
  return numbers;
}

std::optional<formats::ElementType> NetcdfFile::element_type(const Variable& variable) {
  return element_type_of(variable.type);
}

Array<std::byte> NetcdfFile::bytes(const Variable& variable, std::span<const std::uint64_t> shape) const {
  Array<std::byte> result(checked_count(variable, shape, false) * formats::element_bytes(*element_type(variable)));
  check_written(variable);
  if (!result.empty()) check(::nc_get_var(variable.group, variable.id, result.data()), variable.name);
  return result;
}

double NetcdfFile::fill_value(const Variable& variable) const {
  static_assert(NC_FILL_FLOAT == NC_FILL_DOUBLE);
  const bool is_float = variable.type == NC_FLOAT || variable.type == NC_DOUBLE;
  double value = is_float ? NC_FILL_DOUBLE : std::numeric_limits<double>::quiet_NaN();
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (::nc_inq_att(variable.group, variable.id, "_FillValue", &type, &length) == NC_NOERR && length == 1 &&
      element_type_of(type))
    check(::nc_get_att_double(variable.group, variable.id, "_FillValue", &value), variable.name);
  return value;
}

bool NetcdfFile::is_double_precision(const Variable& variable) {
  return variable.type == NC_DOUBLE;
}

}  // namespace rhoray::preprocess
