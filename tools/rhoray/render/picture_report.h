#pragma once

#include "render/document.h"
#include "tools/rhoray/render/command.h"
#include "tools/rhoray/render/picture.h"

namespace rhoray::tools {

/// The words of the layers' methods, each once.
std::string method_text(const render::ResolvedScene& plan);

/// Which choices were made for the user, on stderr.
void say_choices(const CommonOptions& common, const render::ResolvedScene& plan);

/// What is to be known of a picture that was written: the document on stdout with --json, else
/// statistics, picks and checks there, and the rest on stderr.
void report(const RenderCommand& command, const Drawn& drawn);

/// What the scene calls for, on stdout.
void explain(const RenderCommand& command, const render::SceneSpec& scene_spec, const render::ResolvedScene& plan);

}  // namespace rhoray::tools
