#include "render/cells/certified_crossing.h"
namespace rhoray::render {
template CertifiedCrossing certify_crossing<float>(const TrilinearCell&, const Vec3&, const Vec3&, double, double,
                                                   bool);
template CertifiedCrossing certify_crossing<double>(const TrilinearCell&, const Vec3&, const Vec3&, double, double,
                                                    bool);
template CertifiedMaximum certify_largest_value<float>(const TrilinearCell&, const Vec3&, const Vec3&, double);
template CertifiedMaximum certify_largest_value<double>(const TrilinearCell&, const Vec3&, const Vec3&, double);
template std::optional<bool> certain_side<float>(const TrilinearCell&, const Vec3&, double, double);
}  // namespace rhoray::render
