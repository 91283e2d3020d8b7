#pragma once

#include "tools/rhoray/render/command.h"
#include "tools/rhoray/render/picture.h"
#include "tools/rhoray/scene/plan.h"

namespace rhoray::tools {

/// The words of the layers' methods, each once.
std::string method_text(const ScenePlan& plan);

/// Which choices were made for the user, on stderr.
void say_choices(const CommonOptions& common, const ScenePlan& plan);

/// What is to be known of a picture that was written: the document on stdout with --json, else statistics, picks and
/// checks there, and the rest on stderr.
void report(const RenderCommand& command, const Drawn& drawn);

/// What the scene calls for, on stdout.
void explain(const RenderCommand& command, const SceneWishes& wishes, const ScenePlan& plan);

}  // namespace rhoray::tools
