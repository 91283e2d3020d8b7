#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/affine.h"
#include "formats/base/json.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/field_summary.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/pack.h"
#include "render/document.h"

namespace rhoray::tools {

// What packed files and their parts look like in --json, and on a terminal. Numbers that are not
// finite become null.

using rhoray::dump;
using rhoray::dump_lines;
using rhoray::Json;
using rhoray::json_of;  // of vectors and intervals

Json json_of(const Index3& index);
Json json_of(const Box3& box);
Json json_of(const formats::FieldSummary& field);
Json json_of(const formats::Provenance& provenance);
Json json_of(const formats::GridDescription& grid);
Json json_of(const formats::ColorGridDescription& grid);
Json json_of(const formats::TetMeshDescription& mesh);
Json json_of(const formats::TriangleMeshDescription& surface);

/// Where the samples of a volume stand: in the frame of the map at 0, 1, 2, ..., or where a table
/// of the axis says.
struct SampleLattice {
  const Affine& world_from_grid;
  const Index3& sample_count;
  const std::array<std::vector<double>, 3>& axes;
};

/// Origin, direction (three unit vectors), spacing (where it varies along an axis its mean) and,
/// for each axis, the smallest and the largest spacing; all in world units.
Json json_of(const SampleLattice& lattice);

Json json_of(const Affine& world_from_grid);  ///< the same of samples at 0, 1, 2, ... on every axis

/// Of the samples, in world axes.
Box3 bounds_of(const SampleLattice& lattice);

/// "103 x 94 x 161 = 1,558,802 samples U16", "51,419 tetrahedra, 8,278 points, 1 field".
std::string content_of(const preprocess::PackReport& packed);

std::string text_of(const Vec3& v);        ///< 0.781 0.781 1
std::string text_of(const Index3& index);  ///< 512 x 512 x 275
/// One line of blocks, lowest values left; heights are logarithmic, so that a rare value can still
/// be seen.
std::string histogram_bars(const formats::FieldSummary& field, std::size_t width = 64);

/// A scene's document.
/// @param folder  that file names are made relative to; empty: as they are
Json scene_json(const render::SceneSpec& scene_spec, const std::filesystem::path& folder = {});

}  // namespace rhoray::tools
