#pragma once

#include <gtest/gtest.h>
#include <vtkDataObject.h>
#include <vtkNew.h>

#include <filesystem>

#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// Writes a legacy VTK file. vtkDataSetWriter is no writer for this: it ignores the version.
/// @param file_type  VTK_ASCII or VTK_BINARY
/// @param version    42 or 51
template <class Writer>
void write_legacy_vtk(vtkDataObject* data, const std::filesystem::path& path, int file_type, int version) {
  vtkNew<Writer> writer;
  writer->SetInputData(data);
  writer->SetFileVersion(version);
  writer->SetFileType(file_type);
  writer->SetFileName(path.c_str());
  ASSERT_EQ(writer->Write(), 1);
  ASSERT_TRUE(read_file(path).starts_with(version == 42 ? "# vtk DataFile Version 4.2" : "# vtk DataFile Version 5.1"));
}

}  // namespace rhoray::tests
