#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "formats/base/json.h"
#include "render/accuracy.h"
#include "render/document.h"
#include "tools/analysis/effect_costs.h"
#include "tools/pictures/stored_picture.h"
#include "tools/view/client_message.h"

namespace rhoray::tools {

/// The scene that a server shows, and functions of the program that opened it.
struct ViewedScene {
  std::string title;             ///< for the page
  std::string program;           ///< "rhoray 0.1.0"
  render::SceneSpec scene_spec;  ///< what was asked for
  render::ResolvedScene plan{};  ///< resolved from it, with a camera
  /// Resolves the layers of a changed scene (render::resolve_layers). The painter's thread calls
  /// it.
  std::function<render::ResolvedScene(const render::SceneSpec&)> resolve{};
  /// The command that draws a scene.
  std::function<std::string(const render::ResolvedScene&)> command_of{};
  /// The texts of a picture file, with which `rhoray render` draws it again.
  /// @param machine  the instruction set that traced it
  std::function<std::vector<PictureText>(const render::ResolvedScene&, std::string_view machine)> texts_of{};
};

/// A scene as a client changed it.
struct ChangedScene {
  render::SceneSpec scene_spec;
  render::ResolvedScene plan;              ///< without a camera of its own
  std::vector<std::size_t> layer_numbers;  ///< for each layer of the plan, its number in the document
};

/// The scene that clients change, as a document (PROTOCOL.md). It contains every choice about
/// layers except those that the style makes, so that another style can change them.
std::string document_to_change(const ViewedScene& viewed);

/// The scene after a client's changes. Refuses what a document refuses, keys that are not known,
/// and what no client may choose: files, cameras, sizes, and more samples than the limit
/// (ErrorCode::invalid).
/// @param document  document_to_change
/// @param patch     JSON Merge Patch (RFC 7386) of it, an object; empty: nothing is changed
ChangedScene changed_scene(const ViewedScene& viewed, const std::string& document, const std::string& patch);

/// The scene with a request's camera and size; lights follow the camera. While moving there are no
/// annotations and no antialiasing.
render::ResolvedScene with_request(const ViewedScene& viewed, const ChangedScene& scene, const PictureRequest& request);

/// Returns a message about the hit of one pixel (tools/analysis/pick.h), or why there is none, such
/// as that it is outside the picture. Traces one ray, at the level `certified` where layers have it.
/// @param stop  ends the proof of ranges and the preparation
std::string probe_text(const ViewedScene& viewed, const ChangedScene& scene, const PictureRequest& request,
                       const Probe& probe, const std::stop_token& stop);
/// The answer to a probe that cannot be made.
std::string refused_probe_text(const Probe& probe, const std::string& why_not);

// Parts of messages.
Json json_of_camera(const render::Camera& camera);
/// @param ms  that the check took
Json json_of_check(const render::SelfCheck& found, double ms);
Json json_of_effects(const EffectTimes& times);

// Messages to a client, as JSON (PROTOCOL.md).
std::string hello_text(const ViewedScene& viewed, const std::string& document);
std::string resolved_text(const ChangedScene& scene, std::uint32_t request);

}  // namespace rhoray::tools
