#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "preprocess/import_volume.h"
#include "preprocess/open_vdb.h"
#include "render/load.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// A folder for OpenVDB files, with the worker program at hand.
class Vdb : public testing::Test {
 protected:
  Vdb() {
    ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
    openvdb::initialize();
  }

  std::filesystem::path write(const std::string& name, const openvdb::GridPtrVec& grids) const {
    const std::filesystem::path path = folder_ / name;
    openvdb::io::File file(path.string());
    file.write(grids);
    file.close();
    return path;
  }

  static render::Dataset loaded(const std::filesystem::path& path, const std::string& field = {}) {
    return render::Dataset::load(preprocess::open_vdb(path, field));
  }

  TemporaryFolder folder_;
};

template <class Grid>
typename Grid::Ptr named_grid(const std::string& name, const typename Grid::ValueType& background) {
  const auto grid = Grid::create(background);
  grid->setName(name);
  return grid;
}

}  // namespace rhoray::tests
