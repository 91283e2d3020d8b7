#include "tools/lab/peers/ours.h"

#include <algorithm>

#include "formats/base/text.h"
#include "render/method_words.h"
#include "render/ray_caster.h"
#include "render/render.h"
#include "tools/rhoray/bench/parts.h"

namespace rhoray::study {

namespace {

class OwnPeer final : public Peer {
 public:
  OwnPeer(render::Mode mode, const std::string& level) : level_(level) {
    scene_.layers[0].mode = mode;
    scene_.layers[0].method = render::method_of(render::accuracy_named(level));
    scene_.layers[0].material.specular = 0;  // as light_pixel shades the hits of others
  }

  std::string name() const override { return concat("Rhoray, ", level_); }
  std::string does() const override {
    const render::MethodOption option = render::option_of(scene_.layers[0].method, scene_.layers[0].mode, false);
    return concat("method ", option.word, ", from the packed file");
  }

  Preparation prepare(const PeerData& data, double isovalue) override {
    Preparation preparation;
    if (!volume_)
      preparation.once_ms = cpu_ms_of([&] { volume_ = render::Dataset::load(data.packed_file, data.field); });
    scene_.layers[0].isovalue = isovalue;
    scene_.layers[0].window = data.range;
    // The first frame that shows an isovalue contains its cost.
    const double first_ms = cpu_ms_of([&] { show_few_pixels(); });
    preparation.build_ms = std::max(0.0, first_ms - cpu_ms_of([&] { show_few_pixels(); }));
    return preparation;
  }

  void draw(const PeerView& view) override { render(view, {.threads = 1}); }

  std::vector<double> answers(const PeerView& view) override {
    if (scene_.layers[0].mode == render::Mode::mip) {
      render(view, {.channels = {.value = true}});
      return picture_.value;
    }
    // The distances in full precision; `render` rounds them to float.
    const auto rays = render::camera_rays(*volume_, view.camera, view.width, view.height);
    std::vector<render::Hit> hits(rays.size());
    render::RayCaster(*volume_, scene_.layers[0].isovalue, scene_.layers[0].method, 0).first_crossings(rays, hits);
    std::vector<double> distances;
    for (const render::Hit& hit : hits) distances.push_back(hit.t);
    return distances;
  }

  std::string picture_hash() const override { return tools::picture_hash(picture_); }

 private:
  void show_few_pixels() {
    const Box3 box = volume_->bounds();
    render({.camera = {.position = box.center() - Vec3(0, 2, 0) * box.size(), .target = box.center()},
            .width = 4,
            .height = 4},
           {.threads = 1});
  }

  void render(const PeerView& view, render::FrameOptions options) {
    scene_.camera = view.camera;
    options.width = view.width;
    options.height = view.height;
    render::render(*volume_, scene_, options, picture_, memory_);
  }

  std::string level_;
  std::optional<render::Dataset> volume_;
  render::Scene scene_;
  render::Framebuffer picture_;
  render::RenderContext memory_;  // kept from frame to frame, as in a viewer
};

}  // namespace

PeerPointer own_isosurface(const std::string& level) {
  return std::make_unique<OwnPeer>(render::Mode::isosurface, level);
}

PeerPointer own_largest_values(const std::string& level) {
  return std::make_unique<OwnPeer>(render::Mode::mip, level);
}

}  // namespace rhoray::study
