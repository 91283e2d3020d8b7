#include "tools/rhoray/fault_file.h"

#include <map>
#include <set>
#include <string>
#include <vector>

#include "formats/base/pending_file.h"
#include "formats/base/text.h"

namespace rhoray::tools {

void write_fault_file(const std::filesystem::path& path, const preprocess::NeutralSurface& surface,
                      std::span<const preprocess::FaultyFacet> faults, bool replace_existing) {
  std::map<std::uint64_t, std::size_t> position;  // of the points that are used
  std::string points, facets;
  std::set<preprocess::FacetFault> kinds;
  std::size_t facet_count = 0;
  for (const auto& [facet, fault] : faults) {
    const std::uint64_t first = surface.facet_offsets[facet], last = surface.facet_offsets[facet + 1];
    kinds.insert(fault);
    ++facet_count;
    facets += concat(last - first);
    for (std::uint64_t i = first; i < last; ++i) {
      const std::uint64_t corner = surface.facet_corners[i];
      const auto [place, is_new] = position.try_emplace(corner, position.size());
      if (is_new) {
        const auto& p = surface.points[corner];
        points += concat(p[0], " ", p[1], " ", p[2], "\n");
      }
      facets += concat(" ", place->second);
    }
    facets += concat(" ", facet, " ", static_cast<unsigned>(fault), "\n");
  }
  std::string header = "ply\nformat ascii 1.0\ncomment facets for which a surface was refused\n";
  for (const preprocess::FacetFault kind : kinds)
    header += concat("comment fault ", static_cast<unsigned>(kind), ": ", preprocess::name_of(kind), "\n");
  header += concat("element vertex ", position.size(),
                   "\nproperty double x\nproperty double y\nproperty double z\nelement face ", facet_count,
                   "\nproperty list int int vertex_indices\nproperty uint facet\nproperty uchar fault\nend_header\n");
  write_whole_file(path, header + points + facets, replace_existing);
}

}  // namespace rhoray::tools
