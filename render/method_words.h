#pragma once

#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"

namespace rhoray::render {

/// The words of --accuracy, lowest first.
std::vector<std::string> accuracy_words();
Accuracy accuracy_named(const std::string& word);

/// The names for --method of each kind of layer, as sentences of the help.
std::string method_forms();

/// The names of the methods that no accuracy level uses, with an example of an argument.
std::vector<std::string> methods_to_compare(Mode mode, bool is_mesh);

/// The method with this name for this kind of layer; refuses other names and lists the valid ones
/// (ErrorCode::usage).
/// @param asked_by  what the refusal names as its place
Method method_named(const std::string& word, Mode mode, bool is_mesh, const std::string& asked_by = "--method");

/// The option and value that select a picture's method: --accuracy if the method is a level, else
/// --method.
struct MethodOption {
  std::string option, word;
};
MethodOption option_of(const Method& method, Mode mode, bool is_mesh);

}  // namespace rhoray::render
