#include "tools/rhoray/cli/synonyms.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "formats/base/nearest_name.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

/// An option or a subcommand under the name that other programs give it.
struct Synonym {
  std::string_view word;
  const char* ours;
};
constexpr Synonym option_synonyms[] = {{"--isovalue", "--iso"},
                                       {"--isovalues", "--iso"},
                                       {"--isosurface", "--iso"},
                                       {"--threshold", "--iso"},
                                       {"--contour", "--iso"},
                                       {"--width", "--size WIDTHxHEIGHT"},
                                       {"--height", "--size WIDTHxHEIGHT"},
                                       {"--resolution", "--size WIDTHxHEIGHT"},
                                       {"--out", "-o"},
                                       {"--overwrite", "--force"},
                                       {"--array", "--field"},
                                       {"--scalars", "--field"},
                                       {"--variable", "--field"},
                                       {"--cmap", "--colormap"},
                                       {"--palette", "--colormap"},
                                       {"--colour-map", "--colormap"},
                                       {"--color-map", "--colormap"},
                                       {"--log", "--color-scale log"},
                                       {"--log-scale", "--color-scale log"},
                                       {"--logscale", "--color-scale log"},
                                       {"--bg", "--background"},
                                       {"--bg-color", "--background"},
                                       {"--background-color", "--background"},
                                       {"--color", "--surface-color"},
                                       {"--alpha", "--opacity"},
                                       {"--scalar-bar", "--colorbar"},
                                       {"--eye", "--camera-position"},
                                       {"--samples", "--antialias"},
                                       {"--jobs", "--threads"},
                                       {"--clip", "--clip-plane or --clip-box"},
                                       {"--crop", "--clip-box"}};
constexpr Synonym subcommand_synonyms[] = {{"convert", "pack, export or import"},
                                           {"show", "render"},
                                           {"draw", "render"},
                                           {"plot", "render"},
                                           {"picture", "render"},
                                           {"isosurface", "render --iso"},
                                           {"contour", "render --iso"},
                                           {"mip", "render --mode mip"},
                                           {"slice", "render --slice"},
                                           {"inspect", "info"},
                                           {"stat", "info"},
                                           {"ls", "info"},
                                           {"check", "verify"},
                                           {"benchmark", "bench"},
                                           {"diff", "compare"},
                                           {"mesh", "tetrahedralize"},
                                           {"tetgen", "tetrahedralize"},
                                           {"voxelize", "resample"},
                                           {"unpack", "export"}};

std::string hint_for(std::span<const Synonym> synonyms, const std::string& word,
                     const std::vector<std::string>& known) {
  for (const Synonym& synonym : synonyms) {
    if (synonym.word != word) continue;
    const std::string ours = synonym.ours;
    const std::string first = ours.substr(0, ours.find_first_of(" ,"));
    if (first == "-o" || std::find(known.begin(), known.end(), first) != known.end())
      return concat(word, " is ", ours, " here");
  }
  return did_you_mean(word, known);
}

}  // namespace

std::string option_hint(const std::string& word, const std::vector<std::string>& known) {
  return hint_for(option_synonyms, word, known);
}

std::string subcommand_hint(const std::string& word, const std::vector<std::string>& known) {
  return hint_for(subcommand_synonyms, word, known);
}

}  // namespace rhoray::tools
