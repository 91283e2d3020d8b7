#pragma once

/// Marks what librhoray.so exports.
#define RHORAY_API __attribute__((visibility("default")))

/// Keeps what an exported class contains inside.
#define RHORAY_INSIDE __attribute__((visibility("hidden")))

/// The version of the binary interface. Its types and functions stand in a namespace of this name,
/// so that a program that mixes two versions is not linked. The sources of the library have other
/// types with some of these names; there the namespace is not inline.
#ifdef RHORAY_INSIDE_LIBRARY
#define RHORAY_ABI v0_1
#else
#define RHORAY_ABI inline v0_1
#endif
