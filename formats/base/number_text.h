#pragma once

#include <cstdint>
#include <string>

namespace rhoray {

// Numbers for people.
std::string grouped(std::uint64_t number);                                                          ///< 72,089,600
std::string counted(std::uint64_t number, const std::string& singular, const std::string& plural);  ///< 1 cell, 2 cells
std::string bytes_text(std::uint64_t bytes);                                                        ///< 137.5 MiB
std::string rounded(double number, int digits = 4);  ///< that many significant digits, no needless zeros
std::string rounded_up(double number, int digits);   ///< to such a number that is not smaller
/// How many digits, at least four, keep the rounding of a number's text below its error.
int digits_for(double number, double error);
/// At least so many digits, and as many as tell the number to within 1/10,000 of an extent above 0.
std::string rounded_within(double extent, double number, int digits = 4);
/// "12.30067 mm, error at most 1.2e-05 mm". The error includes the rounding of the text.
std::string text_with_error(double number, double error, const std::string& unit);

}  // namespace rhoray
