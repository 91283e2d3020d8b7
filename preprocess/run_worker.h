#pragma once

/// The porch of preprocess/worker: one act in a process of its own with limits, for the doors that have programs of
/// their own beside `rhoray`.
#include "preprocess/process/child_process.h"
