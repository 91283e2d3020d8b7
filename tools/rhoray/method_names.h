#pragma once

#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"

namespace rhoray::tools {

/// The words of --accuracy, lowest first.
std::vector<std::string> accuracy_words();
render::Accuracy accuracy_named(const std::string& word);

/// The words of --method, as --help shows them: one line for each question.
std::string method_help();

/// The method that a word names for this question; refuses others with the words there are (ErrorCode::usage).
/// @param asked_by  what the refusal names as its place
render::Method method_named(const std::string& word, render::Mode mode, bool is_mesh,
                            const std::string& asked_by = "--method");

/// The option and its word by which a picture's method is asked for again: --accuracy where a level is it.
struct MethodOption {
  std::string option, word;
};
MethodOption option_of(const render::Method& method, render::Mode mode, bool is_mesh);

}  // namespace rhoray::tools
