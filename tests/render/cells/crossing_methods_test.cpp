#include "render/cells/crossing_methods.h"
namespace rhoray::render {
template CellCrossing find_crossing<float>(CrossingMethod, const TrilinearCell&, const CellPassage&, double, bool);
template CellCrossing find_crossing<double>(CrossingMethod, const TrilinearCell&, const CellPassage&, double, bool);
}  // namespace rhoray::render
