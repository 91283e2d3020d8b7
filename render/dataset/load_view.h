#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::render {

struct LoadedDataset;

std::shared_ptr<const LoadedDataset> load_grid(const formats::PackedFile& file, const std::string& field);
std::shared_ptr<const LoadedDataset> load_tets(const formats::PackedFile& file, const std::string& field);
std::shared_ptr<const LoadedDataset> load_vdb(const formats::PackedFile& file, const std::string& field);
std::shared_ptr<const LoadedDataset> load_surface(const formats::PackedFile& file, const std::string& field);

/// By the loader of the file's kind; null where the kind cannot be rendered.
std::shared_ptr<const LoadedDataset> load_view(const formats::PackedFile& file, const std::string& field);

/// Refuses a name that is neither empty nor among `names`, and lists these.
void check_field_name(const formats::PackedFile& file, const std::string& field, const std::vector<std::string>& names);

}  // namespace rhoray::render
