#pragma once

/// Rhoray: ray tracing of packed volumes and tetrahedra. This header includes all others.
#include "rhoray/accuracy.h"
#include "rhoray/array_view.h"
#include "rhoray/context.h"
#include "rhoray/dataset.h"
#include "rhoray/document.h"
#include "rhoray/error.h"
#include "rhoray/pack.h"
#include "rhoray/picture.h"
#include "rhoray/progress.h"
#include "rhoray/rays.h"
#include "rhoray/scene.h"
#include "rhoray/types.h"
#include "rhoray/unpack.h"
#include "rhoray/version.h"
