#pragma once

/// Public header of preprocess/process: runs one task in a separate process with limits, for layers
/// that have programs of their own beside `rhoray`.
#include "preprocess/process/child_process.h"
