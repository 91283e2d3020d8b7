#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "render/camera.h"
#include "render/load.h"

namespace rhoray::tools {

/// The views from which speed is measured, after the paper's Table 3.
enum class StudyView {
  front,      ///< all of the data, from -y
  from_feet,  ///< all of the data, from below, 10 degrees off the z axis
  close_up,   ///< the surface that the front view has in its middle, from nearby: it fills the picture in most data
  inside      ///< from the middle of the data, with a wide angle
};
inline constexpr std::array<StudyView, 4> study_views{StudyView::front, StudyView::from_feet, StudyView::close_up,
                                                      StudyView::inside};

const char* name_of(StudyView view);  ///< "front", "from-feet", "close-up", "inside"

/// Refuses other words (ErrorCode::usage).
StudyView study_view_named(const std::string& name);

/// @param isovalue  of the surface that the close view looks at; without one, or where the front
///                  view's middle misses it, the close view looks at the data's box
/// @param aspect    width of the picture over its height
render::Camera study_camera(StudyView view, const render::Dataset& dataset, std::optional<double> isovalue,
                            double aspect);

}  // namespace rhoray::tools
