#pragma once

#include <vector>

#include "formats/base/progress.h"
#include "preprocess/grid/resample/field_view.h"
#include "preprocess/grid/resample/sample.h"

namespace rhoray::preprocess {

/// Margin by which a leaf cell is shrunk on every side when its overlap with the mesh is computed,
/// in steps. It is larger than the amount by which rounding moves a point that lies in a plane of
/// samples.
double overlap_margin(const SampleLattice& lattice);

/// Gives values to the samples without data that a leaf cell needs. A leaf cell needs its samples
/// when it shares a volume with a tetrahedron whose four vertices have data. Afterwards all eight
/// samples of these leaf cells have values. Samples that had data keep them. A new value lies at
/// most one step from the mesh on each axis.
///
/// A new value is the mean of predictions by the tetrahedra around it: those with a part in one of
/// the up to eight leaf cells that need the sample. Each predicts its own linear function,
/// extrapolated to the sample. Its weight is the part's volume times the sample's trilinear weight
/// at the part's centre. A linear field is therefore extrapolated exactly, and a sliver has little
/// weight.
///
/// Predictions are less reliable where they differ from each other by as much as the field's range
/// (slivers, noise, both sides of a gap), or are that far from the values in the parts themselves.
/// Their mean p then has less weight than the mean m of these values. The sample gets
///
///      m + (p - m) range^2 / (max(range^2, (p - m)^2) + variance of the predictions)
///
/// It is therefore at most the field's range below its smallest or above its largest value. The
/// difference between the trilinear field and the mesh's is not known here: the certificate bounds
/// it (certify.h).
///
/// @param views  one for each field
/// @param steps  the mesh's points, in steps of the lattice
void extend_samples(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                    const SampleLattice& lattice, const TouchedBricks& touched, BrickSamples& samples,
                    const Progress& progress);

}  // namespace rhoray::preprocess
