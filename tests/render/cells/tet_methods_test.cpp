#include "render/cells/tet_methods.h"
namespace rhoray::render {
template std::optional<double> find_crossing<float>(TetMethod, const TetRay<float>&, const TetPoints&, const TetValues&,
                                                    double, double);
template std::optional<double> find_crossing<double>(TetMethod, const TetRay<double>&, const TetPoints&,
                                                     const TetValues&, double, double);
template CertifiedTetCrossing certify_tet_crossing<float>(const TetRay<float>&, const TetPoints&, const TetValues&,
                                                          double);
template CertifiedTetCrossing certify_tet_crossing<double>(const TetRay<double>&, const TetPoints&, const TetValues&,
                                                           double);
}  // namespace rhoray::render
