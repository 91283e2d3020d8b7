#pragma once

#include <cstdint>

#include "render/framebuffer.h"
#include "render/load.h"
#include "render/scene.h"

namespace rhoray::render {

struct FrameOptions {
  int width = 1280;
  int height = 720;
  ChannelSet channels{};
  unsigned threads = 0;       ///< 0 = all cores
  bool use_hierarchy = true;  ///< false walks every leaf cell; the picture is the same
  bool use_last_t =
      true;  ///< MIP: prune with the value at the last ray's t (paper, section 4.3); the picture is the same
  bool time_phases = false;  ///< fills FrameStatistics::Phases; costs a few per cent of time
};

/// What was traced for one frame. Counts do not depend on the number of threads.
struct FrameStatistics {
  struct Phases {             ///< CPU seconds, summed over threads (paper, Table 1); 0 unless FrameOptions::time_phases
    double traversal = 0;     ///< rays made and moved from cell to cell, macrocells looked up
    double intersection = 0;  ///< cells and tetrahedra solved
    double shading = 0;       ///< hits made into colours and channels
  };
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  std::uint64_t macrocells_visited = 0;
  std::uint64_t cells_visited = 0;      ///< leaf cells whose values or lists were read
  std::uint64_t cells_solved = 0;       ///< trilinear cells whose cubic was formed, or tetrahedra intersected
  std::uint64_t samples_taken = 0;      ///< by the sampled methods
  std::uint64_t rays_redone = 0;        ///< certified: rays that single precision could not decide
  std::uint64_t rays_judged = 0;        ///< certified and judged: rays decided by exact arithmetic
  std::uint64_t touches = 0;            ///< judged hits at which the field only touches the isovalue
  double largest_error = 0;             ///< of all hits' bounds; NaN where the method proves none
  std::uint64_t highlights_shaded = 0;  ///< hits for which the specular effect was computed
  Phases phases;
  double wall_s = 0;
};

/// Traces one ray through the middle of every pixel. The framebuffer is the same, bit for bit, for any number of
/// threads. Refuses a picture without pixels, an isovalue or a camera that is not finite, a method that does not answer
/// the question, and the channel `error` where the method proves nothing (Trouble::usage).
FrameStatistics render(const Volume& volume, const Scene& scene, const FrameOptions& options, Framebuffer& framebuffer);

}  // namespace rhoray::render
