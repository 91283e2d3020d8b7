#pragma once

#include <string>
#include <vector>

#include "formats/base/json.h"

namespace rhoray::tools {

/// Measurements: rows of named values. All rows have the columns of the first, in its order.
struct Table {
  std::string name;  ///< "phases": also the name of its files
  std::string title;
  Json context;  ///< where and how it was measured
  std::vector<Json> rows;
};

std::string text_of(const Table& table);  ///< columns side by side, numbers rounded
std::string csv_of(const Table& table);   ///< numbers in full; RFC 4180
Json json_of(const Table& table);         ///< name, title, context, rows

}  // namespace rhoray::tools
