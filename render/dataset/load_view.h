#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/packed_file.h"
#include "formats/space.h"

namespace rhoray::render {

struct LoadedDataset;

std::shared_ptr<const LoadedDataset> load_grid(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const Watch& watch);
std::shared_ptr<const LoadedDataset> load_tets(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const Watch& watch);
std::shared_ptr<const LoadedDataset> load_vdb(const formats::PackedFile& file, const std::string& field,
                                              formats::Space world, const Watch& watch);
std::shared_ptr<const LoadedDataset> load_surface(const formats::PackedFile& file, const std::string& field,
                                                  formats::Space world, const Watch& watch);

/// The boundary of a mesh, or of a label of it (Dataset::boundary).
std::shared_ptr<const LoadedDataset> load_boundary(const LoadedDataset& mesh, const Watch& watch);
std::shared_ptr<const LoadedDataset> load_boundary(const LoadedDataset& mesh, const std::string& cell_field, int label,
                                                   std::span<const int> without, const Watch& watch);

/// By the loader of the file's kind; null where the kind cannot be rendered.
/// @param world  as for Dataset::load; only grids know their space
std::shared_ptr<const LoadedDataset> load_view(const formats::PackedFile& file, const std::string& field,
                                               formats::Space world, const Watch& watch);

/// Names of the fields that can colour hits (Dataset::color_names).
std::vector<std::string> color_names(const LoadedDataset& dataset);

/// Refuses a name that is neither empty nor among `names`, and lists these.
void check_field_name(const formats::PackedFile& file, const std::string& field, const std::vector<std::string>& names);

}  // namespace rhoray::render
