#pragma once

namespace rhoray::tools {

/// A format that `rhoray export` writes, and which kind of packed file it can hold.
struct ExportFormat {
  const char *extension, *name;
  bool for_grids, for_tets;
  const char* other;  ///< what to say to a file of the other kind
};
inline constexpr ExportFormat export_formats[] = {
    {".vti", "VTK image data", true, false, "export a mesh as .vtu"},
    {".vdb", "OpenVDB", true, false, "`rhoray resample` converts a mesh to a grid"},
    {".nvdb", "NanoVDB", true, false, "`rhoray resample` converts a mesh to a grid"},
    {".nii", "NIfTI", true, false, "`rhoray resample` converts a mesh to a grid"},
    {".npy", "NumPy", true, false, "numpy reads points, cells and fields from the packed file: see formats/SPEC.md"},
    {".vtu", "VTK unstructured grid", false, true, "export a grid as .vti"},
    {".stl", "STL", true, true, ""}};

}  // namespace rhoray::tools
