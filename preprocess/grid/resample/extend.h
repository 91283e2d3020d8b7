#pragma once

#include <vector>

#include "preprocess/grid/resample/field_view.h"
#include "preprocess/grid/resample/sample.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// How much smaller a leaf cell is taken on every side when its overlap with the mesh is sought, in steps: more than
/// what rounding moves a point that lies in a plane of samples.
double overlap_margin(const SampleLattice& lattice);

/// Gives values to the samples without data that a leaf cell needs: one that shares a volume with a tetrahedron whose
/// four vertices have data. Afterwards all eight samples of these leaf cells have values. Samples that had data keep
/// them. A new value stands at most one step from the mesh on each axis.
///
/// A new value is the mean of what the tetrahedra around it say: those with a part in one of the up to eight leaf cells
/// that need the sample. Each tells its own linear function, continued to the sample; its weight is the part's volume
/// by the sample's trilinear weight at the part's centre. So a linear field is continued exactly, and a sliver counts
/// little.
///
/// Where these predictions differ from each other by as much as the field's range (slivers, noise, both sides of a
/// gap), or are that far from the values in the parts themselves, their mean p is worth less than the mean m of these
/// values. The sample gets
///
///      m + (p - m) range^2 / (max(range^2, (p - m)^2) + variance of the predictions)
///
/// so that it stands at most the field's range below its smallest or above its largest value. How far the trilinear
/// field then lies from the mesh's is not known here: the certificate bounds it (certify.h).
///
/// @param views  one for each field; steps: the mesh's points, in steps of the lattice
void extend_samples(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                    const SampleLattice& lattice, const TouchedBricks& touched, BrickSamples& samples,
                    const Progress& progress);

}  // namespace rhoray::preprocess
