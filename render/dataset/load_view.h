#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "formats/packed_file.h"
#include "formats/space.h"

namespace rhoray::render {

struct LoadedDataset;

std::shared_ptr<const LoadedDataset> load_grid(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const std::stop_token& stop);
std::shared_ptr<const LoadedDataset> load_tets(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const std::stop_token& stop);
std::shared_ptr<const LoadedDataset> load_vdb(const formats::PackedFile& file, const std::string& field,
                                              formats::Space world, const std::stop_token& stop);
std::shared_ptr<const LoadedDataset> load_surface(const formats::PackedFile& file, const std::string& field,
                                                  formats::Space world, const std::stop_token& stop);

/// The boundary of a mesh, or of a label of it (Dataset::boundary).
std::shared_ptr<const LoadedDataset> load_boundary(const LoadedDataset& mesh, const std::stop_token& stop);
std::shared_ptr<const LoadedDataset> load_boundary(const LoadedDataset& mesh, const std::string& cell_field, int label,
                                                   std::span<const int> without, const std::stop_token& stop);

/// By the loader of the file's kind; null where the kind cannot be rendered.
/// @param world  as for Dataset::load; only grids know their space
/// @param stop   ends loading (ErrorCode::interrupted), here and above
std::shared_ptr<const LoadedDataset> load_view(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const std::stop_token& stop);

/// Names of the fields that can colour hits (Dataset::color_names).
std::vector<std::string> color_names(const LoadedDataset& dataset);

/// Refuses a name that is neither empty nor among `names`, and lists these.
void check_field_name(const formats::PackedFile& file, const std::string& field, const std::vector<std::string>& names);

}  // namespace rhoray::render
