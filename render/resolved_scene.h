#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/heat_map.h"
#include "render/load.h"
#include "render/render.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// An angle by which no surface turns (Dataset::feature_edges).
inline constexpr double no_feature_edges = 180;

/// Where a layer of the planned scene comes from.
struct LayerOrigin {
  std::size_t spec = 0;                         ///< index into SceneSpec::layers
  std::string isovalue_from;                    ///< Isovalue::from; empty for others
  bool is_context = false;                      ///< the boundary around an isosurface (LayerSpec::context)
  std::string isovalue_alternatives{};          ///< Isovalue::alternatives
  double feature_edges_deg = no_feature_edges;  ///< as for Dataset::feature_edges
  /// These edges, drawn over the picture; null: none. Copies of the scene share them.
  std::shared_ptr<const FeatureEdges> lines{};
};

/// Everything that was chosen.
struct ResolvedScene {
  std::vector<Dataset> datasets;
  std::vector<DataSpec> data;  ///< of each dataset, with the name of its field
  std::vector<Texture> textures;
  std::vector<DataSpec> texture_data;  ///< of each texture
  Scene scene;
  formats::Space space = formats::Space::ras;  ///< of the world, for files that say which is theirs
  std::string style;                           ///< whose defaults were taken
  std::vector<LayerOrigin> origins;            ///< of each layer
  FrameOptions frame;
  std::optional<DebugChannel> page;  ///< drawn instead of colours
  AnnotationsSpec annotations;
  bool has_default_annotations = false;  ///< the layers need some that were not asked for
  Box3 annotated_box;                    ///< around what is shown, where annotations ask for it
  std::vector<std::string> notes;        ///< what was left out or chosen otherwise than asked, one line each
};

}  // namespace rhoray::render
