#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::preprocess {

/// The header of a NRRD file, up to the empty line before its samples and with it. All of the text
/// when there is no such line.
std::string_view nrrd_header(std::string_view text);

/// The sample files that a header names: one file, a list, or a numbered series.
std::vector<std::string> files_named_by(std::string_view header);

/// Refuses another beginning than that of NRRD files. Teem would also accept PNG, PNM and text.
void check_nrrd_magic(const std::filesystem::path& path);

/// Refuses a file that Teem does not read. The message names the first fault of the header, else
/// the header's line that Teem quotes, else the samples.
/// @param reason  what Teem says
[[noreturn]] void refuse_nrrd(const std::filesystem::path& path, std::string_view reason);

}  // namespace rhoray::preprocess
