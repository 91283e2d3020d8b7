#pragma once

#include <cstdint>
#include <string>

namespace rhoray {

// Numbers for people.
std::string grouped(std::uint64_t number);                                                          ///< 72,089,600
std::string counted(std::uint64_t number, const std::string& singular, const std::string& plural);  ///< 1 cell, 2 cells
std::string bytes_text(std::uint64_t bytes);                                                        ///< 137.5 MiB
std::string rounded(double number, int digits = 4);  ///< that many significant digits, no needless zeros

}  // namespace rhoray
