#pragma once

#include <filesystem>

#include "preprocess/resample.h"
#include "preprocess/resample/certify.h"
#include "preprocess/resample/sample.h"

namespace rhoray::preprocess {

/// A mesh on a lattice, ready to be written.
struct ResampledMesh {
  SampleLattice lattice;
  TouchedBricks touched;
  BrickSamples samples;
  Certificates certificates;
};

/// Writes a packed grid with the bricks that have a sample inside the mesh. Adds description and file_bytes.
void write_grid(const ResampledMesh& grid, const CleanMesh& mesh, const std::vector<PointField>& fields,
                const std::string& length_unit, const std::filesystem::path& path, const ResampleOptions& options,
                const Progress& progress, ResampleReport& report);

}  // namespace rhoray::preprocess
