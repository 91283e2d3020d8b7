#include "preprocess/inspect_surface.h"

#include <algorithm>

#include "formats/base/error.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/messages.h"
#include "preprocess/workers/tetgen/job.h"

namespace rhoray::preprocess {

std::string_view name_of(FacetFault fault) {
  switch (fault) {
    case FacetFault::not_finite:
      return "not finite";
    case FacetFault::flat:
      return "without area";
    case FacetFault::twin:
      return "there twice";
    case FacetFault::at_open_edge:
      return "at an open edge";
    case FacetFault::at_crowded_edge:
      return "at an edge of more than two facets";
    case FacetFault::crossing:
      return "crossing another";
  }
  throw Error(ErrorCode::internal, concat("facet fault ", static_cast<int>(fault), "; expected one of 1 to 6"));
}

std::vector<FaultyFacet> find_faults(const NeutralSurface& surface, bool solids_may_touch) {
  WorkerRequest request;
  request.program = "rhoray-tetgen-worker";
  request.doing = "looking for faults of a surface";
  request.arguments = {find_faults_verb, concat(int{solids_may_touch})};
  request.write_input = [&](int descriptor) { send(surface, descriptor); };
  const formats::PackedFile answer = run_worker(request);
  if (!answer.has("facets")) return {};
  const auto facets = answer.array<std::uint64_t>("facets", {0});
  const auto faults = answer.array<std::uint8_t>("faults", {facets.size()});
  std::vector<FaultyFacet> found;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (facets[i] + 1 >= surface.facet_offsets.size())
      throw Error(ErrorCode::internal, concat("looking for faults: facet ", facets[i], " is not there"));
    found.push_back({facets[i], static_cast<FacetFault>(faults[i])});
    name_of(found.back().fault);  // refuses a number that is no fault
  }
  return found;
}

void hand_over_faults(std::span<const FaultyFacet> faults, int descriptor) {
  std::vector<std::uint64_t> facets;
  std::vector<std::uint8_t> kinds;
  for (const FaultyFacet& f : faults) {
    facets.push_back(f.facet);
    kinds.push_back(static_cast<std::uint8_t>(f.fault));
  }
  std::vector<formats::ArraySpec> arrays;
  if (!faults.empty())
    arrays = {{.name = "facets", .type = formats::ElementType::U64, .shape = {facets.size()}, .alignment = 64},
              {.name = "faults", .type = formats::ElementType::U8, .shape = {kinds.size()}, .alignment = 64}};
  formats::FileDescription description;
  description.kind = "surface-faults";
  formats::PackedFileWriter writer(descriptor, description, arrays);
  if (!faults.empty()) {
    writer.write("facets", 0, std::as_bytes(std::span(facets)));
    writer.write("faults", 0, std::as_bytes(std::span(kinds)));
  }
  writer.commit();
}

}  // namespace rhoray::preprocess
