#pragma once

#include <cstddef>
#include <utility>

#include "formats/file_description.h"

/// The header of NIfTI-1 (nifti1.h), for reader and writer.
namespace rhoray::preprocess::nifti {

inline constexpr std::size_t header_bytes = 348;

// Byte offsets of the fields in use.
inline constexpr std::size_t dim = 40, datatype = 70, bitpix = 72, pixdim = 76, vox_offset = 108, scl_slope = 112,
                             scl_inter = 116, xyzt_units = 123, toffset = 136, qform_code = 252, sform_code = 254,
                             quatern = 256, qoffset = 268, srow = 280, magic = 344;

/// Codes of numbers.
inline constexpr std::pair<int, formats::ElementType> data_types[] = {
    {2, formats::ElementType::U8},    {4, formats::ElementType::I16},   {8, formats::ElementType::I32},
    {16, formats::ElementType::F32},  {64, formats::ElementType::F64},  {256, formats::ElementType::I8},
    {512, formats::ElementType::U16}, {768, formats::ElementType::U32}, {1024, formats::ElementType::I64},
    {1280, formats::ElementType::U64}};

/// Units of length by their code; empty for a code without a unit.
inline constexpr const char* length_units[] = {"", "m", "mm", "um", "", "", "", ""};

}  // namespace rhoray::preprocess::nifti
