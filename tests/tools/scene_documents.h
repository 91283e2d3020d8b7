#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "formats/base/error.h"
#include "render/document.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/data_choice.h"

/// Scene documents that are read and planned, and the messages about them.
namespace rhoray::tests {

/// The messages about a document; the bench's folder is left out of names.
struct Answer {
  std::string fact, hint;
  int exit_code = 0;
  std::vector<std::string> warnings;
};

class SceneDocument : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    bench_ = new Workbench;
    bench_->make_ball();
    bench_->make_box();
    bench_->make_photo();
    bench_->make_cube();
    write_file(*bench_ / "ball.txt", "not a volume");
  }
  static void TearDownTestSuite() {
    delete bench_;
    bench_ = nullptr;
  }

  static const Workbench& bench() { return *bench_; }

  static std::string without_folder(std::string text) {
    const std::string folder = bench().path().string() + "/";
    for (std::size_t at; (at = text.find(folder)) != std::string::npos;) text.erase(at, folder.size());
    return text;
  }

  /// Reads and plans s.json with this text.
  static Answer answer_to(const std::string& text) {
    write_file(bench() / "s.json", text);
    Answer answer;
    try {
      const render::SceneDocument document = render::read_scene(bench() / "s.json");
      for (const std::string& warning : document.warnings) answer.warnings.push_back(without_folder(warning));
      render::ResolvedScene plan = tools::resolve_layers(document.scene_spec);
      render::aim_camera(document.scene_spec, plan);
    } catch (const Error& error) {
      answer.fact = without_folder(error.what());
      answer.hint = without_folder(error.hint());
      answer.exit_code = static_cast<int>(error.code());
    }
    return answer;
  }

 private:
  static inline Workbench* bench_ = nullptr;
};

/// A correct scene with one member replaced by a faulty one.
inline std::string with(const std::string& key, const std::string& value) {
  const auto member = [&](const char* name, const char* good) {
    return concat('"', name, "\": ", key == name ? value : good);
  };
  std::string text = concat("{", member("data", R"({"ball": {"file": "ball.rho"}})"), ", ",
                            member("layers", R"([{"type": "isosurface", "isovalue": 100}])"));
  if (key != "data" && key != "layers") text += concat(", \"", key, "\": ", value);
  return text + "}";
}
inline std::string with_layer(const std::string& members) {
  return with("layers", concat(R"([{"type": "isosurface", "isovalue": 100}, {"type": "isosurface", )", members, "}]"));
}

/// A layer of the ball beside the colours in photo.rho.
inline std::string with_texture(const std::string& members, const std::string& photo = R"({"file": "photo.rho"})") {
  return concat(R"({"data": {"ball": {"file": "ball.rho"}, "photo": )", photo,
                R"(}, "layers": [{"type": "isosurface", "data": "ball", "isovalue": 100, )", members, "}]}");
}

}  // namespace rhoray::tests
