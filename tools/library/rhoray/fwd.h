#pragma once

#include "rhoray/export.h"

/// Declares the classes, for headers that only name them.
namespace rhoray::RHORAY_ABI {

class Dataset;
class Error;
class FieldSampler;
class Picture;
class RayCaster;
class RayScratch;
class RenderContext;
class SceneDocument;
class Texture;
struct Camera;
struct Layer;
struct Scene;

}  // namespace rhoray::RHORAY_ABI
