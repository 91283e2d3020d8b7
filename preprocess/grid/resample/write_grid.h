#pragma once

#include <filesystem>

#include "preprocess/grid/resample/certify.h"
#include "preprocess/grid/resample/sample.h"
#include "preprocess/resample.h"

namespace rhoray::preprocess {

/// A mesh on a lattice, ready to be written.
struct ResampledMesh {
  SampleLattice lattice;
  TouchedBricks touched;
  BrickSamples samples;
  Certificates certificates;
};

/// Writes a packed grid with the bricks that have a sample inside the mesh or a value given to one
/// outside. Sets description and file_bytes.
/// @param requested_error  of the first field, for its certificate
void write_grid(const ResampledMesh& grid, const CleanMesh& mesh, const std::vector<ScalarField>& fields,
                const std::string& length_unit, std::optional<double> requested_error,
                const std::filesystem::path& path, const ResampleOptions& options, const Progress& progress,
                ResampleReport& report);

}  // namespace rhoray::preprocess
