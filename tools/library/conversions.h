#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "render/probe.h"
#include "render/resolved_scene.h"
#include "rhoray/context.h"
#include "rhoray/scene.h"
#include "tools/library/plain_types.h"

/// Between the types of the public headers (outside) and those of the rooms (inside).
namespace rhoray::v0_1::inside {

inline constexpr int longest_side = 65536;  ///< of a picture, in pixels

render::Camera inside_of(const Camera& camera);
Camera outside_of(const render::Camera& camera);

/// Refuses a number that is no accuracy level.
render::Method inside_of(const Method& method);
/// Refuses methods that only the program has (ErrorCode::unsupported).
Method outside_of(const render::Method& method);

render::ChannelSet inside_of(const ChannelSet& channels);
ChannelSet outside_of(const render::ChannelSet& channels);

/// The scene with its datasets, and everything else that a document says. Without a camera it has
/// that of render::Scene.
/// Refuses what no scene may hold; the rest is refused where it is used.
/// @param watch  watches the loading of fields
render::ResolvedScene resolved(const Scene& scene, const RenderOptions& options, const rhoray::Watch& watch = {});

/// Refuses a scene without a camera. Otherwise as above.
render::ResolvedScene resolved_with_camera(const Scene& scene, const RenderOptions& options,
                                           const rhoray::Watch& watch = {});

/// The data that a document names, by render::DataSpec::name.
using OpenedData = std::map<std::string, Dataset>;

/// The scene of a document whose choices are made.
Scene outside_of(const render::ResolvedScene& resolved, const OpenedData& opened);
RenderOptions options_of(const render::ResolvedScene& resolved);

Statistics outside_of(const render::FrameStatistics& statistics);
ProbeHit outside_of(const render::ProbeHit& hit);

/// Refuses a number that is no instruction set.
/// @param name  of the argument, for messages
render::Machine inside_of(Machine machine, std::string_view name);
/// The instruction set that was asked for, or the best. Refuses one that this processor does not
/// have (ErrorCode::unsupported).
render::Machine machine_of(const std::optional<Machine>& machine, std::string_view name);

}  // namespace rhoray::v0_1::inside
