#pragma once

#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Refuses a netCDF file in a classic format (CDF-1, CDF-2, CDF-5) that is shorter than the
/// variables in its header need, or whose header is damaged. Accepts files that begin differently.
/// Source: the grammar in "NetCDF Classic Format Specification", appendix of the NetCDF Users
/// Guide.
void check_classic_netcdf(const ForeignFile& file);

}  // namespace rhoray::preprocess
