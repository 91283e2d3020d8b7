#include "render/frame/render_context.h"

namespace rhoray::render {

const TileThreads& RenderContext::Implementation::threads(unsigned threads) {
  if (!threads_ || threads_->asked_for() != threads) threads_.emplace(threads, arena_);
  return *threads_;
}

void RenderContext::Implementation::begin_frame(unsigned threads, const WorkerNeeds& needs) {
  places_.resize(this->threads(threads).worker_count());
  for (Place& place : places_) place.works = false;
  needs_ = needs;
}

Worker& RenderContext::Implementation::worker(std::size_t index) {
  Place& place = places_[index];
  if (!place.worker) place.worker = std::make_unique<Worker>();
  if (!place.works) place.worker->begin_frame(needs_);
  place.works = true;
  return *place.worker;
}

std::vector<const Worker*> RenderContext::Implementation::workers() const {
  std::vector<const Worker*> working;
  for (const Place& place : places_)
    if (place.works) working.push_back(place.worker.get());
  return working;
}

}  // namespace rhoray::render
