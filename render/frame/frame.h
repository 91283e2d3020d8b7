#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/frame/pixel_rays.h"
#include "render/frame/pixels.h"
#include "render/frame/tile_threads.h"
#include "render/frame/tiles.h"
#include "render/frame/worker.h"
#include "render/kernels/kernels.h"
#include "render/render.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

/// What was chosen once for the frame; nothing here changes while tiles are traced.
struct Frame {
  const VolumeImplementation& volume;
  Kernel kernel;
  Preparation prepare;  ///< null: nothing to prepare
  std::size_t queue_entries;
  Question question;
  Look look;
  CameraRays camera_rays;
  Affine volume_from_world;
  std::optional<SurfaceBoxes> boxes{};  ///< nothing is met outside them; none: not known
};

/// Pixels that are traced one after another before anyone looks: those of a few lattices. Rays are made, and the kernel
/// is asked about them, in blocks of pixels that may see one of the frame's boxes; the others are background.
class Pass {
 public:
  void add(const Frame& frame, const PixelLattice& lattice);

  std::size_t tile_count() const { return tiles_.size(); }
  void trace_tile(const Frame& frame, std::size_t index, Worker& worker, Framebuffer& out) const;

 private:
  struct Part {
    PixelLattice lattice;
    PixelRays rays;
  };
  struct PartTile {
    std::size_t part;
    Tile tile;
  };
  static void trace_blocks(const Frame& frame, const Part& part, const Tile& tile, Worker& worker, Framebuffer& out);

  std::vector<Part> parts_;
  std::vector<PartTile> tiles_;
};

/// The threads, and their memory, made by each of them when it first works.
class FrameMemory::Implementation {
 public:
  /// @param threads  as FrameOptions::threads
  void begin_frame(unsigned threads, std::size_t queue_entries);
  const TileThreads& threads() const { return *threads_; }
  Worker& worker(std::size_t index);
  /// Those that have worked in this frame.
  std::vector<const Worker*> workers() const;

 private:
  struct Place {
    std::unique_ptr<Worker> worker;
    bool works = false;  ///< in this frame
  };
  std::optional<TileThreads> threads_;
  std::vector<Place> places_;
  std::size_t queue_entries_ = 0;
};

}  // namespace rhoray::render
