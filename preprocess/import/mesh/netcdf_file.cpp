#include "preprocess/import/mesh/netcdf_file.h"

#include <netcdf.h>

#include <algorithm>

#include "formats/base/bytes.h"
#include "preprocess/import/mesh/netcdf_classic.h"

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

}  // namespace

NetcdfFile::NetcdfFile(const std::filesystem::path& path) : path_(path) {
  const ForeignFile file(path);
  check_classic_netcdf(file);
  file_bytes_ = file.bytes().size();
  // An absolute name cannot be mistaken for a network address.
  check(::nc_open(std::filesystem::absolute(path).c_str(), NC_NOWRITE, &id_), "header");
}

NetcdfFile::~NetcdfFile() {
  ::nc_close(id_);
}

void NetcdfFile::check(int status, std::string_view place) const {
  if (status == NC_NOERR) return;
  if (status == NC_ENOMEM) throw Error(ErrorCode::resource, concat(path_.string(), ", ", place, ": out of memory"));
  refuse_input(path_, place, "damaged data, or another format", "a netCDF file");
}

std::optional<std::uint64_t> NetcdfFile::dimension(const std::string& name) const {
  int id = 0;
  std::size_t size = 0;
  if (::nc_inq_dimid(id_, name.c_str(), &id) != NC_NOERR) return std::nullopt;
  check(::nc_inq_dimlen(id_, id, &size), name);
  return size;
}

std::optional<NetcdfFile::Variable> NetcdfFile::variable(const std::string& name) const {
  Variable result;
  result.name = name;
  if (::nc_inq_varid(id_, name.c_str(), &result.id) != NC_NOERR) return std::nullopt;
  int axes = 0;
  check(::nc_inq_vartype(id_, result.id, &result.type), name);
  check(::nc_inq_varndims(id_, result.id, &axes), name);
  std::vector<int> dimensions(static_cast<std::size_t>(axes));
  check(::nc_inq_vardimid(id_, result.id, dimensions.data()), name);
  for (const int dimension : dimensions) {
    std::size_t size = 0;
    check(::nc_inq_dimlen(id_, dimension, &size), name);
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

Array<double> NetcdfFile::numbers(const Variable& variable, std::span<const std::uint64_t> shape,
                                  std::optional<std::uint64_t> first) const {
  Array<double> result(checked_count(variable, shape, first.has_value()));
  std::vector<std::size_t> start(variable.shape.size(), 0), count(variable.shape.begin(), variable.shape.end());
  if (first) {
    start.front() = *first;
    count.front() = 1;
  }
  if (!result.empty())
    check(::nc_get_vara_double(id_, variable.id, start.data(), count.data(), result.data()), variable.name);
  return result;
}

Array<std::int64_t> NetcdfFile::integers(const Variable& variable, std::span<const std::uint64_t> shape) const {
  static_assert(sizeof(long long) == sizeof(std::int64_t));
  Array<std::int64_t> result(checked_count(variable, shape, false));
  if (variable.type == NC_FLOAT || variable.type == NC_DOUBLE)
    refuse_input(path_, concat("variable '", variable.name, "'"), "floating-point numbers", "integers");
  if (!result.empty())
    check(::nc_get_var_longlong(id_, variable.id, reinterpret_cast<long long*>(result.data())), variable.name);
  return result;
}

std::vector<std::string> NetcdfFile::texts(const Variable& variable) const {
  if (variable.type != NC_CHAR || variable.shape.size() != 2 || variable.shape[1] == 0)
    refuse_input(path_, concat("variable '", variable.name, "'"), text_of(variable.shape),
                 "a table of letters, one name in each row");
  const std::uint64_t length = variable.shape[1];
  std::string letters(checked_count(variable, variable.shape, false), '\0');
  if (!letters.empty()) check(::nc_get_var_text(id_, variable.id, letters.data()), variable.name);
  std::vector<std::string> result;
  for (std::uint64_t row = 0; row < variable.shape[0]; ++row) {
    std::string text = letters.substr(row * length, length);
    text.resize(std::min(text.find('\0'), text.size()));
    text.resize(text.find_last_not_of(" \t") + 1);
    result.push_back(std::move(text));
  }
  return result;
}

std::string NetcdfFile::text_attribute(const Variable& variable, const std::string& name) const {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (::nc_inq_att(id_, variable.id, name.c_str(), &type, &length) != NC_NOERR || type != NC_CHAR) return {};
  std::string text(length, '\0');
  if (length > 0) check(::nc_get_att_text(id_, variable.id, name.c_str(), text.data()), variable.name);
  text.resize(std::min(text.find('\0'), text.size()));
  text.resize(text.find_last_not_of(" \t") + 1);
  return text;
}

bool NetcdfFile::is_double_precision(const Variable& variable) {
  return variable.type == NC_DOUBLE;
}

}  // namespace rhoray::preprocess
