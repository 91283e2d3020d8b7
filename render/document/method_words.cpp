#include "render/method_words.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/read_value.h"
#include "formats/base/text.h"
#include "formats/base/word_list.h"

namespace rhoray::render {

namespace {

using Algorithm = Method::Algorithm;

constexpr std::pair<const char*, Accuracy> accuracies[] = {{"preview", Accuracy::preview},
                                                           {"float", Accuracy::float32},
                                                           {"double", Accuracy::float64},
                                                           {"certified", Accuracy::certified},
                                                           {"exact", Accuracy::exact}};

/// The argument after a method's name: sampled:STEP, slack:EPS.
enum class Argument { none, step, slack };

struct MethodWord {
  const char* word;
  Algorithm algorithm;
  Argument argument;
  bool of_grids, of_meshes;
  const char* example;  ///< with an argument; empty if an accuracy level uses the algorithm
};
constexpr MethodWord isosurface_words[] = {{"bracketed", Algorithm::direct, Argument::none, true, false, ""},
                                           {"edges", Algorithm::direct, Argument::none, false, true, ""},
                                           {"paper", Algorithm::paper, Argument::none, true, true, "paper"},
                                           {"slack", Algorithm::slack, Argument::slack, false, true, "slack:1e-6"},
                                           {"sampled", Algorithm::sampled, Argument::step, true, true, "sampled:0.5"}};
constexpr MethodWord mip_words[] = {{"exact", Algorithm::direct, Argument::none, true, true, ""},
                                    {"face", Algorithm::paper, Argument::none, true, true, "face"},
                                    {"sampled", Algorithm::sampled, Argument::step, true, true, "sampled:0.5"}};

std::vector<MethodWord> words_for(Mode mode, bool is_mesh) {
  std::vector<MethodWord> words;
  const auto take = [&](const auto& table) {
    for (const MethodWord& row : table)
      if (is_mesh ? row.of_meshes : row.of_grids) words.push_back(row);
  };
  if (mode == Mode::mip)
    take(mip_words);
  else
    take(isosurface_words);
  return words;
}

std::string form_of(const MethodWord& word) {
  switch (word.argument) {
    case Argument::step:
      return concat(word.word, ":STEP[+linear|+bisect]");
    case Argument::slack:
      return concat(word.word, ":EPS[:float|:double]");
    case Argument::none:
      break;
  }
  return concat(word.word, "[:float|:double]");
}

std::string forms(Mode mode, bool is_mesh) {
  return joined(names_in(words_for(mode, is_mesh), form_of));
}

/// Takes `ending` off the end of a word; false when the word does not end so.
bool take_ending(std::string& word, std::string_view ending) {
  if (!word.ends_with(ending)) return false;
  word.resize(word.size() - ending.size());
  return true;
}

}  // namespace

std::vector<std::string> accuracy_words() {
  return names_in(accuracies, &std::pair<const char*, Accuracy>::first);
}

Accuracy accuracy_named(const std::string& word) {
  for (const auto& [name, accuracy] : accuracies)
    if (word == name) return accuracy;
  throw Error(ErrorCode::usage,
              concat("--accuracy: found '", word, "'; expected preview, float, double, certified or exact"),
              did_you_mean(word, accuracy_words()));
}

std::string method_forms() {
  return concat("Grids: ", forms(Mode::isosurface, false), ". Meshes: ", forms(Mode::isosurface, true),
                ". MIP: ", forms(Mode::mip, false));
}

std::vector<std::string> methods_to_compare(Mode mode, bool is_mesh) {
  std::vector<std::string> words = names_in(words_for(mode, is_mesh), &MethodWord::example);
  std::erase(words, "");
  return words;
}

Method method_named(const std::string& word, Mode mode, bool is_mesh, const std::string& asked_by) {
  const auto refuse = [&]() -> Method {
    throw Error(ErrorCode::usage, concat(asked_by, ": found '", word, "'; expected one of ", forms(mode, is_mesh)),
                did_you_mean(word, names_in(words_for(mode, is_mesh), &MethodWord::word)));
  };
  const std::size_t colon = word.find(':');
  const std::string name = word.substr(0, colon);
  std::string rest = colon == std::string::npos ? "" : word.substr(colon + 1);
  for (const MethodWord& row : words_for(mode, is_mesh)) {
    if (name != row.word) continue;
    Method method{.algorithm = row.algorithm};
    if (row.argument == Argument::step) {
      method.bisect = take_ending(rest, "+bisect");
      if (!method.bisect) take_ending(rest, "+linear");
      const std::optional<double> step = finite_number(rest);
      if (!step) return refuse();
      require_within(asked_by + " sampled:", *step, 1e-4, 1e4);
      method.step = *step;
      return method;
    }
    if (row.argument == Argument::slack) {
      if (take_ending(rest, ":float"))
        method.precision = Method::Precision::float32;
      else
        take_ending(rest, ":double");
      const std::optional<double> slack = finite_number(rest);
      if (!slack) return refuse();
      require_within(asked_by + " slack:", *slack, 0, 1);
      method.slack = *slack;
      return method;
    }
    if (rest == "float")
      method.precision = Method::Precision::float32;
    else if (colon != std::string::npos && rest != "double")
      return refuse();
    return method;
  }
  return refuse();
}

MethodOption option_of(const Method& method, Mode mode, bool is_mesh) {
  for (const auto& [word, accuracy] : accuracies)
    if (method_of(accuracy) == method) return {"--accuracy", word};
  const char* const precision = method.precision == Method::Precision::float32 ? ":float" : ":double";
  for (const MethodWord& row : words_for(mode, is_mesh)) {
    if (row.algorithm != method.algorithm) continue;
    switch (row.argument) {
      case Argument::step:
        return {"--method", concat(row.word, ":", method.step, method.bisect ? "+bisect" : "+linear")};
      case Argument::slack:
        return {"--method", concat(row.word, ":", method.slack, precision)};
      case Argument::none:
        return {"--method", concat(row.word, precision)};
    }
  }
  return {"--accuracy", "float"};
}

}  // namespace rhoray::render
