#include "tools/rhoray/scene/document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/trouble.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/scene/plan.h"
#include "tools/rhoray/scene/schema.h"
#include "tools/rhoray/scene/spelled_out.h"
#include "tools/rhoray/scene/tables.h"

namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using tools::Json;

/// What is said of a document; the bench's folder is left out of names.
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
      const tools::SceneDocument document = tools::read_scene(bench() / "s.json");
      for (const std::string& warning : document.warnings) answer.warnings.push_back(without_folder(warning));
      tools::ScenePlan plan = tools::plan_layers(document.wishes);
      tools::aim_camera(document.wishes, plan);
    } catch (const Error& error) {
      answer.fact = without_folder(error.what());
      answer.hint = without_folder(error.hint());
      answer.exit_code = static_cast<int>(error.trouble());
    }
    return answer;
  }

 private:
  static Workbench* bench_;
};
Workbench* SceneDocument::bench_ = nullptr;

/// A scene that has nothing wrong, with one member replaced by what is wrong.
std::string with(const std::string& key, const std::string& value) {
  const auto member = [&](const char* name, const char* good) {
    return concat('"', name, "\": ", key == name ? value : good);
  };
  std::string text = concat("{", member("data", R"({"ball": {"file": "ball.rho"}})"), ", ",
                            member("layers", R"([{"type": "isosurface", "isovalue": 100}])"));
  if (key != "data" && key != "layers") text += concat(", \"", key, "\": ", value);
  return text + "}";
}
std::string with_layer(const std::string& members) {
  return with("layers", concat(R"([{"type": "isosurface", "isovalue": 100}, {"type": "isosurface", )", members, "}]"));
}

struct Mistake {
  std::string document;
  std::string fact;
  std::string hint = "";
  int exit_code = 4;
};

/// A layer of the ball beside the colours in photo.rho.
std::string with_texture(const std::string& members, const std::string& photo = R"({"file": "photo.rho"})") {
  return concat(R"({"data": {"ball": {"file": "ball.rho"}, "photo": )", photo,
                R"(}, "layers": [{"type": "isosurface", "data": "ball", "isovalue": 100, )", members, "}]}");
}

std::vector<Mistake> mistakes() {
  const std::string isovalue = "expected a number, \"auto\" or a percentile such as \"p95\"";
  const std::string color = "expected a colour: \"#rrggbb\", or linear [r, g, b] from 0 to 1";
  const std::string size = "expected [width, height] from 1 to 65536, or \"720p\", \"1080p\", \"4k\"";
  const std::string views = R"(expected one of "iso", "+x", "-x", "+y", "-y", "+z", "-z")";
  const std::string channels = R"("depth", "normal", "cell", "value", "error", "roots", "iterations", "cost")";
  const std::string levels = R"(expected one of "preview", "float", "double", "certified", "exact")";
  std::string deep = R"({"data": )";
  for (int level = 0; level < 20; ++level) deep += "[";
  return {
      // not JSON
      {"",
       "s.json, line 1, column 1: syntax error while parsing value - unexpected end of input; expected '[', '{', or a "
       "literal"},
      {"{\n  \"data\": {,}\n}",
       "s.json, line 2, column 12: syntax error while parsing object key - unexpected ','; expected string literal"},
      {"{\"data\": 1",
       "s.json, line 1, column 11: syntax error while parsing object - unexpected end of input; expected '}'"},
      {deep, "s.json: /data" +
                 [] {
                   std::string zeros;
                   for (int i = 0; i < 15; ++i) zeros += "/0";
                   return zeros;
                 }() +
                 ": nested deeper than 16 levels"},
      {R"({"data": {"a": {"file": "ball.rho", "file": "box.rho"}}, "layers": []})",
       "s.json: /data/a/file: the key is there twice"},
      {R"({"layers": [], "layers": []})", "s.json: /layers: the key is there twice"},
      {with_layer(R"("isovalue": 1e999)"), "s.json: /layers/1/isovalue: found 1e999; expected a finite number"},

      // the document
      {"[1, 2]", "s.json: found [1,2]; expected an object"},
      {"{}",
       "s.json: has no \"data\"; expected an object of files by name, such as {\"head\": {\"file\": \"head.rho\"}}"},
      {R"({"data": {"ball": {"file": "ball.rho"}}})",
       "s.json: has no \"layers\"; expected an array of 1 to 254 layers"},
      {with("accuracy", "\"flaot\""), "s.json: /accuracy: found \"flaot\"; " + levels, "did you mean float?"},
      {with("accuracy", "3"), "s.json: /accuracy: found 3; " + levels},

      // data
      {with("data", "{}"),
       "s.json: /data: found an object; expected an object of files by name, such as {\"head\": {\"file\": "
       "\"head.rho\"}}"},
      {with("data", "\"ball.rho\""),
       "s.json: /data: found \"ball.rho\"; expected an object of files by name, such as {\"head\": {\"file\": "
       "\"head.rho\"}}"},
      {with("data", R"({"ball": "ball.rho"})"), "s.json: /data/ball: found \"ball.rho\"; expected an object"},
      {with("data", R"({"a/b": {}})"), "s.json: /data/a~1b: has no \"file\"; expected a file"},
      {with("data", R"({"ball": {"file": ""}})"), "s.json: /data/ball/file: found \"\"; expected a file"},
      {with("data", R"({"ball": {"file": "bal.rho"}})"), "s.json: /data/ball/file: bal.rho: no such file",
       "did you mean ball.rho?", 3},
      {with("data", R"({"ball": {"file": "ball.rho", "field": "bone"}})"),
       "s.json: /data/ball/field: ball.rho: no field 'bone'; it has 'ball'"},
      {with("data", R"({"ball": {"file": "box.rho", "field": "heigth"}})"),
       "s.json: /data/ball/field: box.rho: no field 'heigth'; it has 'height', 'length'", "did you mean height?"},
      {with("data", R"({"ball": {"file": "ball.rho", "field": 1}})"),
       "s.json: /data/ball/field: found 1; expected a text"},

      // layers
      {with("layers", "[]"), "s.json: /layers: found []; expected an array of 1 to 254 layers"},
      {with("layers", "{}"), "s.json: /layers: found an object; expected an array of 1 to 254 layers"},
      {with("layers", "[7]"), "s.json: /layers/0: found 7; expected an object"},
      {with("layers", "[{}]"),
       "s.json: /layers/0: has no \"type\"; expected one of \"isosurface\", \"mip\", \"mesh\", \"slice\""},
      {with("layers", R"([{"type": "isosurfce"}])"),
       "s.json: /layers/0/type: found \"isosurfce\"; expected one of \"isosurface\", \"mip\", \"mesh\", \"slice\"",
       "did you mean isosurface?"},
      {with("layers", R"([{"type": "isosurface", "visible": false}])"),
       "s.json: /layers: no layer is visible; expected at least one"},
      {with_layer(R"("visible": "yes")"), "s.json: /layers/1/visible: found \"yes\"; expected true or false"},
      {with_layer(R"("data": "bal")"), "s.json: /layers/1/data: found \"bal\"; expected \"ball\"",
       "did you mean ball?"},
      {R"({"data": {"a": {"file": "ball.rho"}, "b": {"file": "box.rho"}}, "layers": [{"type": "mip"}]})",
       "s.json: /layers/0: has no \"data\"; expected one of \"a\", \"b\""},
      {with_layer(R"("isovalue": "hihg")"), "s.json: /layers/1/isovalue: found \"hihg\"; " + isovalue},
      {with_layer(R"("isovalue": "aut")"), "s.json: /layers/1/isovalue: found \"aut\"; " + isovalue,
       "did you mean auto?"},
      {with_layer(R"("isovalue": "p101")"), "s.json: /layers/1/isovalue: found \"p101\"; " + isovalue},
      {with_layer(R"("isovalue": null)"), "s.json: /layers/1/isovalue: found null; " + isovalue},
      {with_layer(R"("isovalue": [])"), "s.json: /layers/1/isovalue: found []; " + isovalue + ", or an array of these"},
      {with_layer(R"("isovalue": [100, true])"), "s.json: /layers/1/isovalue/1: found true; " + isovalue},
      {with("layers", R"([{"type": "isosurface", "isovalue": 900}])"),
       "s.json: /layers/0/isovalue: isovalue 900 is outside the range 0 to 237 of field 'ball'",
       "auto takes one from the histogram"},
      {with("layers", R"([{"type": "isosurface", "isovalue": [900, -4]}])"),
       "s.json: /layers/0/isovalue/0: isovalue 900 is outside the range 0 to 237 of field 'ball'",
       "auto takes one from the histogram"},
      {with_layer(R"("range": [0, 10])"),
       "s.json: /layers/1/range: on a surface it is of the colours by a field: \"color_by\" names it"},
      {with_layer(R"("colormap": "gray")"),
       "s.json: /layers/1/colormap: is of the colours by a field: \"color_by\" names it"},
      {with_layer(R"("color_by": "bal")"), "s.json: /layers/1/color_by: no field 'bal'; there is 'ball'",
       "did you mean ball?"},
      // textures
      {with_texture(R"("texture": 3)"), "s.json: /layers/0/texture: found 3; expected a text"},
      {with_texture(R"("texture": "phto")"),
       "s.json: /layers/0/texture: found \"phto\"; expected one of \"ball\", \"photo\"", "did you mean photo?"},
      {with_texture(R"("texture": "ball")"),
       "s.json: /layers/0/texture: ball.rho: holds a grid; expected a packed file of colours",
       "rhoray pack --color makes it of a folder of pictures, .nrrd, .mha or .vti"},
      {with_texture(R"("texture": "photo")", R"({"file": "photo.nrrd"})"),
       "s.json: /layers/0/texture: photo.nrrd: is not a packed file; expected a packed file of colours",
       "rhoray pack --color makes it of a folder of pictures, .nrrd, .mha or .vti"},
      {with_texture(R"("texture": "photo")", R"({"file": "foto.rho"})"),
       "s.json: /data/photo/file: foto.rho: no such file", "did you mean photo.rho?", 3},
      {with_texture(R"("texture": "photo")", R"({"file": "photo.rho", "field": "red"})"),
       "s.json: /layers/0/texture: photo.rho: field 'red': colours have no fields"},
      {with_texture(R"("texture": "photo", "color_by": "ball")"),
       "s.json: /layers/0/texture: \"color_by\" is there too; expected one of the two"},
      {R"({"data": {"photo": {"file": "photo.rho"}}, "layers": [{"type": "isosurface"}]})",
       "s.json: /data/photo/file: photo.rho: holds colours; expected a grid, a mesh or a surface",
       "colours cover a surface of other data: --texture FILE, or the key \"texture\" of a scene's layer"},
      {with("layers", R"([{"type": "mip", "texture": "photo"}])"),
       "s.json: /layers/0/texture: found in a layer of type \"mip\"; expected in one of type \"isosurface\""},
      {with_layer(R"("color_by": "ball", "colormap": "viridsi")"),
       "s.json: /layers/1/colormap: found \"viridsi\"; expected one of \"viridis\", \"cubehelix\", \"gray\", "
       "\"coolwarm\"",
       "did you mean viridis?"},
      {with_layer(R"("normals": "smooth")"), "s.json: /layers/1/normals: 'smooth' is of meshes, and ball.rho is a grid",
       "exact, the gradient of the trilinear field, is how grids are lit"},
      {with("layers", R"([{"type": "mip", "normals": "flat"}])"),
       "s.json: /layers/0/normals: found in a layer of type \"mip\"; expected in one of type \"isosurface\""},
      {with("layers", R"([{"type": "mip", "isovalue": 4}])"),
       "s.json: /layers/0/isovalue: found in a layer of type \"mip\"; expected in one of type \"isosurface\""},
      {with("layers", R"([{"type": "mip", "range": [9, 4]}])"),
       "s.json: /layers/0/range: found [9,4]; expected two numbers [a, b] with a below b"},
      {with_layer(R"("color": "red")"), "s.json: /layers/1/color: found \"red\"; " + color},
      {with_layer(R"("color": [0, 1, 2])"), "s.json: /layers/1/color: found [0,1,2]; " + color},
      {with_layer(R"("specular": 1.5)"), "s.json: /layers/1/specular: found 1.5; expected a number from 0 to 1"},
      {with_layer(R"("shininess": 0)"), "s.json: /layers/1/shininess: found 0; expected a number from 1 to 10000"},
      {with_layer(R"("ambient": {"a": 1})"),
       "s.json: /layers/1/ambient: found an object; expected a number from 0 to 1"},
      {with_layer(R"("accuracy": "exact", "method": "paper")"),
       "s.json: /layers/1/method: \"accuracy\" is there too; expected one of the two"},
      {with_layer(R"("method": "papr")"),
       "s.json: /layers/1/method: found 'papr'; expected one of bracketed[:float|:double], paper[:float|:double], "
       "sampled:STEP[+linear|+bisect]",
       "did you mean paper?"},

      // triangles
      {with("layers", R"([{"type": "mesh"}])"),
       "s.json: /layers/0/data: ball.rho: is a grid; expected a packed surface of triangles",
       "its isosurfaces are layers of type \"isosurface\""},
      {R"({"data": {"b": {"file": "box.rho"}}, "layers": [{"type": "mesh"}]})",
       "s.json: /layers/0/data: box.rho: is a mesh of tetrahedra; expected a packed surface of triangles",
       "its isosurfaces are layers of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.off"}}, "layers": [{"type": "mesh"}]})",
       "s.json: /data/c/file: cube.off: is not a packed file", "pack it first: rhoray pack cube.off -o cube.rho"},
      {R"({"data": {"c": {"file": "cube.rho", "field": "a"}}, "layers": [{"type": "mesh"}]})",
       "s.json: /data/c/field: cube.rho: no field 'a'; a surface has no fields"},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "mesh", "isovalue": 1}]})",
       "s.json: /layers/0/isovalue: found in a layer of type \"mesh\"; expected in one of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "mesh", "color_by": "a"}]})",
       "s.json: /layers/0/color_by: found in a layer of type \"mesh\"; expected in one of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "mesh", "normals": "exact"}]})",
       "s.json: /layers/0/normals: found \"exact\"; expected one of \"flat\", \"smooth\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "mesh", "accuracy": "exact"}]})",
       "s.json: /layers/0: --accuracy: found 'exact'; expected float or double of cube.rho, which holds triangles"},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "mip"}]})",
       "s.json: /layers/0: --mode: is of fields, and cube.rho holds triangles, shown as they are"},

      // slices
      {with("layers", R"([{"type": "slice"}])"),
       "s.json: /layers/0: has no plane; expected \"axis\", or \"point\" and \"normal\""},
      {with("layers", R"([{"type": "slice", "point": [0, 0, 0]}])"),
       "s.json: /layers/0: has no plane; expected \"axis\", or \"point\" and \"normal\""},
      {with("layers", R"([{"type": "slice", "axis": "w"}])"),
       "s.json: /layers/0/axis: found \"w\"; expected one of \"x\", \"y\", \"z\"", "did you mean x?"},
      {with("layers", R"([{"type": "slice", "position": 4, "normal": [0, 0, 1]}])"),
       "s.json: /layers/0/position: is of an axis; expected \"axis\" too"},
      {with("layers", R"([{"type": "slice", "axis": "x", "normal": [0, 0, 1]}])"),
       "s.json: /layers/0/axis: \"point\" or \"normal\" is there too; expected one of the two"},
      {with("layers", R"([{"type": "slice", "normal": [0, 0, 0]}])"),
       "s.json: /layers/0/normal: found [0,0,0]; expected three numbers [x, y, z], not all 0"},
      {with("layers", R"([{"type": "slice", "axis": "x", "threshold": [3, 3]}])"),
       "s.json: /layers/0/threshold: found [3,3]; expected two numbers [a, b] with a below b"},
      {with("layers", R"([{"type": "slice", "axis": "x", "colormap": "grey"}])"),
       "s.json: /layers/0/colormap: found \"grey\"; expected one of \"viridis\", \"cubehelix\", \"gray\", "
       "\"coolwarm\"",
       "did you mean gray?"},
      {with("layers", R"([{"type": "slice", "axis": "x", "isovalue": 4}])"),
       "s.json: /layers/0/isovalue: found in a layer of type \"slice\"; expected in one of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "slice", "axis": "x"}]})",
       "s.json: /layers/0: --slice: is of fields, and cube.rho holds triangles, shown as they are"},

      // lights
      {with("lights", R"([{"type": "directional", "azimuth": 9, "angular_diameter": 181}])"),
       "s.json: /lights/0/angular_diameter: found 181; expected a number from 0 to 180"},
      {with("lights", R"([{"type": "directional", "azimuth": 9, "radius": 1}])"),
       "s.json: /lights/0/radius: found in a light of type \"directional\"; expected in one of type \"point\""},
      {with("lights", R"([{"type": "point", "position": [0, 0, 9], "radius": -1}])"),
       "s.json: /lights/0/radius: found -1; expected a number from 0 up"},
      {with("lights", R"([{"type": "point", "position": [0, 0, 9], "samples": 0}])"),
       "s.json: /lights/0/samples: found 0; expected a whole number from 1 to 4096"},
      {with("lights", "{}"), "s.json: /lights: found an object; expected an array of 0 to 64 lights"},
      {with("lights", "[{}]"),
       "s.json: /lights/0: has no \"type\"; expected one of \"head\", \"directional\", \"point\""},
      {with("lights", R"([{"type": "sun"}])"),
       "s.json: /lights/0/type: found \"sun\"; expected one of \"head\", \"directional\", \"point\""},
      {with("lights", R"([{"type": "head"}, {"type": "point"}])"),
       "s.json: /lights/1: has no \"position\"; expected three numbers [x, y, z]"},
      {with("lights", R"([{"type": "head", "shadows": true}])"),
       "s.json: /lights/0/shadows: found in a light of type \"head\"; expected in one of type \"directional\""},
      {with("lights", R"([{"type": "directional"}])"),
       "s.json: /lights/0: has no direction; expected \"direction\", or \"azimuth\" and \"elevation\""},
      {with("lights", R"([{"type": "directional", "direction": [0, 0, 0]}])"),
       "s.json: /lights/0/direction: found [0,0,0]; expected a direction"},
      {with("lights", R"([{"type": "directional", "direction": [0, 0, 1], "elevation": 9}])"),
       "s.json: /lights/0/direction: \"elevation\" is there too; expected one of the two"},
      {with("lights", R"([{"type": "directional", "azimuth": 9, "from": "camra"}])"),
       "s.json: /lights/0/from: found \"camra\"; expected one of \"world\", \"camera\"", "did you mean camera?"},
      {with("lights", R"([{"type": "head", "intensity": -1}])"),
       "s.json: /lights/0/intensity: found -1; expected a number from 0 to 10000"},
      {with("lights", R"([{"type": "head", "color": [2, 2, 2]}])"), "s.json: /lights/0/color: found [2,2,2]; " + color},

      // effects
      {with("effects", "[]"), "s.json: /effects: found []; expected an object"},
      {with("effects", R"({"ambient_occlusion": true})"),
       "s.json: /effects/ambient_occlusion: found true; expected an object"},
      {with("effects", R"({"ambient_occlusion": {"samples": 2.5}})"),
       "s.json: /effects/ambient_occlusion/samples: found 2.5; expected a whole number from 1 to 4096"},
      {with("effects", R"({"ambient_occlusion": {"samples": 5000}})"),
       "s.json: /effects/ambient_occlusion/samples: found 5000; expected a whole number from 1 to 4096"},
      {with("effects", R"({"ambient_occlusion": {"radius": 0}})"),
       "s.json: /effects/ambient_occlusion/radius: found 0; expected a number above 0"},
      {with("effects", R"({"fog": {"range": [5, 5]}})"),
       "s.json: /effects/fog/range: found [5,5]; expected two numbers [a, b] with a below b"},

      // clip
      {with("clip", "[0, 1]"), "s.json: /clip: found [0,1]; expected an object"},
      {with("clip", "{}"), "s.json: /clip: has no region; expected \"box\" or \"planes\""},
      {with("clip", R"({"keep": "outside"})"), "s.json: /clip: has no region; expected \"box\" or \"planes\""},
      {with("clip", R"({"box": [0, 1]})"), "s.json: /clip/box/0: found 0; expected three numbers [x, y, z]"},
      {with("clip", R"({"box": [[0, 0, 0], [1, 0, 1]]})"),
       "s.json: /clip/box: found [[0,0,0],[1,0,1]]; expected two corners [[x, y, z], [x, y, z]], each number of the "
       "first below that of the second"},
      {with("clip", R"({"box": [[0, 0, 0], [1, 1, 1e999]]})"),
       "s.json: /clip/box/1/2: found 1e999; expected a finite number"},
      {with("clip", R"({"planes": []})"), "s.json: /clip/planes: found []; expected an array of 1 to 6 planes"},
      {with("clip", R"({"planes": [1, 2, 3, 4, 5, 6, 7]})"),
       "s.json: /clip/planes: found [1,2,3,4,5,6,7]; expected an array of 1 to 6 planes"},
      {with("clip", R"({"planes": [{"point": [0, 0, 0]}]})"),
       "s.json: /clip/planes/0: has no \"normal\"; expected three numbers [x, y, z], not all 0"},
      {with("clip", R"({"planes": [{"point": [0, 0, 0], "normal": [0, 0, 0]}]})"),
       "s.json: /clip/planes/0/normal: found [0,0,0]; expected three numbers [x, y, z], not all 0"},
      {with("clip", R"({"planes": [{"point": [0, 0], "normal": [0, 0, 1]}]})"),
       "s.json: /clip/planes/0/point: found [0,0]; expected three numbers [x, y, z]"},
      {with("clip", R"({"box": [[0, 0, 0], [1, 1, 1]], "keep": "outsde"})"),
       "s.json: /clip/keep: found \"outsde\"; expected one of \"inside\", \"outside\"", "did you mean outside?"},
      {with_layer(R"("clip": "no")"), "s.json: /layers/1/clip: found \"no\"; expected true or false"},

      // camera
      {with("camera", "[]"), "s.json: /camera: found []; expected an object"},
      {with("camera", R"({"view": "front"})"), "s.json: /camera/view: found \"front\"; " + views},
      {with("camera", R"({"elevation": 91})"), "s.json: /camera/elevation: found 91; expected a number from -90 to 90"},
      {with("camera", R"({"zoom": 0})"), "s.json: /camera/zoom: found 0; expected a number from 1e-06 to 1e+06"},
      {with("camera", R"({"fov": "wide"})"),
       "s.json: /camera/fov: found \"wide\"; expected a number from 0.001 to 179"},
      {with("camera", R"({"ortho": 1})"), "s.json: /camera/ortho: found 1; expected true or false"},
      {with("camera", R"({"ortho_height": -1})"), "s.json: /camera/ortho_height: found -1; expected a number above 0"},
      {with("camera", R"({"position": [1, 2]})"),
       "s.json: /camera/position: found [1,2]; expected three numbers [x, y, z]"},
      {with("camera", R"({"up": [0, 0, "z"]})"),
       "s.json: /camera/up: found [0,0,\"z\"]; expected three numbers [x, y, z]"},
      {with("camera", R"({"position": [0, 0, 9], "target": [0, 0, 0]})"),
       "s.json: /camera: the camera has no direction: position, target and up lie on one line",
       "give another \"up\" or \"target\""},

      // image
      {with("image", R"({"size": [0, 10]})"), "s.json: /image/size: found [0,10]; " + size},
      {with("image", R"({"size": [1.5, 10]})"), "s.json: /image/size: found [1.5,10]; " + size},
      {with("image", R"({"size": "huge"})"), "s.json: /image/size: found \"huge\"; " + size},
      {with("image", R"({"background": "#12345"})"), "s.json: /image/background: found \"#12345\"; " + color},
      {with("image", R"({"channels": "depth"})"),
       "s.json: /image/channels: found \"depth\"; expected an array of " + channels},
      {with("image", R"({"channels": ["depht"]})"),
       "s.json: /image/channels/0: found \"depht\"; expected one of " + channels, "did you mean depth?"},
      {with("image", R"({"channels": ["cost", "cost"]})"),
       "s.json: /image/channels/1: found \"cost\"; expected each word once"},
      {with("image", R"({"channels": ["error"]})"),
       "s.json: /image/channels: the channel 'error' needs a method that proves one: certified or exact"},
      {with("image", R"({"show": "error"})"),
       "s.json: /image/show: the channel 'error' needs a method that proves one: certified or exact"},
      {with("image", R"({"antialias": 65})"),
       "s.json: /image/antialias: found 65; expected a whole number from 1 to 64"},

      // annotations
      {with("annotations", "true"), "s.json: /annotations: found true; expected an object"},
      {with("annotations", R"({"axes": "left"})"),
       "s.json: /annotations/axes: found \"left\"; expected true, false or an object"},
      {with("annotations", R"({"axes": {"corner": "lfet"}})"),
       "s.json: /annotations/axes/corner: found \"lfet\"; expected one of \"left\", \"right\"", "did you mean left?"},
      {with("annotations", R"({"box": {}})"), "s.json: /annotations/box: found an object; expected true or false"},
      {with("annotations", R"({"caption": ""})"), "s.json: /annotations/caption: found \"\"; expected a text"},
      {with("annotations", R"({"colorbar": {"position": "top"}})"),
       "s.json: /annotations/colorbar/position: found \"top\"; expected one of \"left\", \"right\""},
      {with("annotations", R"({"colorbar": true})"),
       "s.json: /annotations/colorbar: no layer shows values by colours; expected one of a projection, or coloured by "
       "a "
       "field"},
  };
}

TEST_F(SceneDocument, says_of_every_mistake_where_it_is_what_was_found_and_what_is_expected) {
  ASSERT_GE(mistakes().size(), 60U);
  for (const Mistake& mistake : mistakes()) {
    SCOPED_TRACE(mistake.document);
    const Answer answer = answer_to(mistake.document);
    EXPECT_EQ(answer.fact, mistake.fact);
    EXPECT_EQ(answer.hint, mistake.hint);
    EXPECT_EQ(answer.exit_code, mistake.exit_code);
    EXPECT_EQ(answer.fact.find('\n'), std::string::npos);
  }
  EXPECT_EQ(answer_to(with("accuracy", "\"double\"")).fact, "") << "the scene that the cases spoil has nothing wrong";
}

TEST_F(SceneDocument, refuses_what_is_too_large) {
  EXPECT_EQ(answer_to(std::string((4U << 20) + 1, ' ')).fact,
            "s.json: is larger than 4 MiB; expected a scene document");
  std::string layers;
  for (int i = 0; i < 257; ++i) layers += concat(i == 0 ? "" : ",", R"({"type": "mip"})");
  EXPECT_EQ(answer_to(with("layers", concat("[", layers, "]"))).fact,
            "s.json: /layers: found an array of 257; expected an array of 1 to 254 layers");
  std::string isovalues;
  for (int i = 1; i < 200; ++i) isovalues += concat(i == 1 ? "" : ",", i);
  const std::string many = concat(R"({"type": "isosurface", "isovalue": [)", isovalues, "]}");
  EXPECT_EQ(answer_to(with("layers", concat("[", many, ",", many, "]"))).fact,
            "s.json: /layers: more than 254 layers and isovalues");
}

TEST_F(SceneDocument, warns_of_unknown_keys_with_the_nearest_one) {
  EXPECT_THAT(answer_to(with("camera", R"({"zomm": 2})")).warnings,
              ElementsAre("s.json: /camera/zomm: unknown key, not read; did you mean zoom?"));
  EXPECT_THAT(answer_to(with("effects", R"({"fogg": {}})")).warnings,
              ElementsAre("s.json: /effects/fogg: unknown key, not read; did you mean fog?"));
  EXPECT_THAT(answer_to(with("flamingo", "1")).warnings, ElementsAre("s.json: /flamingo: unknown key, not read"));
  const Answer layer = answer_to(with_layer(R"("isovlaue": 3)"));
  EXPECT_THAT(layer.warnings, ElementsAre("s.json: /layers/1/isovlaue: unknown key, not read; did you mean isovalue?"));
  EXPECT_EQ(layer.fact, "");
}

tools::ScenePlan planned(const std::filesystem::path& file) {
  const tools::SceneDocument document = tools::read_scene(file);
  tools::ScenePlan plan = tools::plan_layers(document.wishes);
  tools::aim_camera(document.wishes, plan);
  return plan;
}

TEST_F(SceneDocument, shows_several_isovalues_of_several_files) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "x": {"file": "box.rho", "field": "length"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": [50, "p99", 900], "specular": 0},
               {"type": "mip", "data": "b", "visible": false},
               {"type": "isosurface", "data": "x", "isovalue": 0.5, "color": [0.5, 0.25, 0]}]})");
  const tools::ScenePlan plan = planned(bench() / "s.json");
  ASSERT_EQ(plan.scene.layers.size(), 3U);
  EXPECT_EQ(plan.volumes.size(), 2U);
  EXPECT_EQ(plan.scene.layers[0].isovalue, 50);
  EXPECT_EQ(plan.origins[1].isovalue_from, "percentile 99");
  EXPECT_EQ(plan.scene.layers[2].volume, 1U);
  EXPECT_EQ(plan.scene.layers[2].surface.color, Vec3(0.5, 0.25, 0));
  EXPECT_EQ(plan.scene.layers[1].surface.specular, 0);
  EXPECT_NE(plan.scene.layers[0].surface.color, plan.scene.layers[1].surface.color);
  EXPECT_THAT(plan.notes, ElementsAre(HasSubstr("isovalue 900 is outside the range")));
}

TEST_F(SceneDocument, opens_only_what_is_visible) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "t": {"file": "ball.txt"}},
    "layers": [{"type": "mip", "data": "b"}, {"type": "mip", "data": "t", "visible": false}]})");
  EXPECT_EQ(planned(bench() / "s.json").volumes.size(), 1U);
}

TEST_F(SceneDocument, opens_a_texture_once_and_only_where_a_visible_layer_names_it) {
  const auto plan_with = [](const std::string& layers) {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}, "p": {"file": "photo.rho"}, )",
                                          R"("t": {"file": "ball.txt"}}, "layers": [)", layers, "]}"));
    return planned(bench() / "s.json");
  };
  const tools::ScenePlan none = plan_with(R"({"type": "isosurface", "data": "b", "isovalue": 100},
    {"type": "isosurface", "data": "b", "isovalue": 90, "texture": "t", "visible": false})");
  EXPECT_EQ(none.textures.size(), 0U);
  const tools::ScenePlan two = plan_with(R"({"type": "isosurface", "data": "b", "isovalue": [100, 110], "texture": "p"},
    {"type": "isosurface", "data": "b", "isovalue": 90, "texture": "p"})");
  ASSERT_EQ(two.textures.size(), 1U);
  ASSERT_EQ(two.scene.layers.size(), 3U);
  for (const render::Layer& layer : two.scene.layers)
    EXPECT_EQ(&layer.surface.texture->grid(), &two.textures[0].grid());
  EXPECT_THAT(two.notes, testing::IsEmpty());
}

TEST_F(SceneDocument, notes_a_texture_that_lies_elsewhere) {
  const auto notes_of = [](const std::string& origin, double isovalue) {
    const RunResult packed =
        bench().rhoray({"pack", "photo.nrrd", "--color", "--origin", origin, "-o", "moved.rho", "-q", "--force"});
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    write_file(bench() / "s.json",
               concat(R"({"data": {"b": {"file": "ball.rho"}, "p": {"file": "moved.rho"}}, "layers": [)",
                      R"({"type": "isosurface", "data": "b", "isovalue": )", isovalue, R"(, "texture": "p"}]})"));
    return planned(bench() / "s.json").notes;
  };
  EXPECT_THAT(notes_of("1,1,1", 100), testing::IsEmpty());
  EXPECT_THAT(notes_of("10,1,1", 100), testing::IsEmpty());
  const auto is_told = ElementsAre(
      testing::AllOf(HasSubstr("moved.rho covers nothing of layer 0"), HasSubstr("check spacing and origin")));
  EXPECT_THAT(notes_of("100,1,1", 100), is_told);
  // Beside a small surface, but within the data's bounds.
  EXPECT_THAT(notes_of("20,1,1", 230), is_told);
}

TEST_F(SceneDocument, gives_surfaces_without_a_colour_one_each_only_where_there_are_several) {
  const auto colors = [&](const std::string& layers) {
    write_file(bench() / "s.json", with("layers", layers));
    std::vector<Vec3> list;
    for (const render::Layer& layer : planned(bench() / "s.json").scene.layers) list.push_back(layer.surface.color);
    return list;
  };
  EXPECT_EQ(colors(R"([{"type": "isosurface", "isovalue": 100}])").at(0), render::Surface{}.color);
  const std::vector<Vec3> eight = colors(R"([{"type": "isosurface", "isovalue": [10, 20, 30, 40, 50, 60, 70, 80]}])");
  for (std::size_t i = 0; i < eight.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((eight[i] - eight[j]).length(), 0.1) << i << " " << j;
}

TEST_F(SceneDocument, spelled_out_is_planned_to_the_same_scene) {
  write_file(bench() / "s.json",
             R"({"data": {"b": {"file": "ball.rho"}, "x": {"file": "box.rho"}, "p": {"file": "photo.rho"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": ["auto", 33.3], "method": "sampled:0.25+bisect"},
               {"type": "mip", "data": "x", "clip": false}, {"type": "mip", "data": "x", "range": [0.1, 0.7]},
               {"type": "isosurface", "data": "x", "normals": "smooth", "color_by": "length", "colormap": "gray", "range": [0, 2]},
               {"type": "isosurface", "data": "b", "isovalue": 44, "texture": "p"},
               {"type": "slice", "data": "x", "axis": "z", "position": 0.3, "threshold": [0.1, 0.9], "opacity": 0.8},
               {"type": "slice", "data": "x", "normal": [1, 2, 3], "colormap": "gray", "range": [0.2, 0.3], "lit": true}],
    "lights": [{"type": "directional", "azimuth": 20, "elevation": 30, "from": "camera", "shadows": true},
               {"type": "point", "position": [1, 2, 3], "color": [0.9, 0.7, 0.1], "intensity": 3.3, "radius": 0.25,
                "samples": 9, "shadows": true},
               {"type": "directional", "direction": [1, 2, 3], "shadows": true, "angular_diameter": 0.53},
               {"type": "head", "intensity": 0.3}],
    "effects": {"ambient_occlusion": {"samples": 5}, "fog": {"color": [0.1, 0.2, 0.3]}},
    "clip": {"box": [[0.1, -9, -9], [9, 9, 9.3]], "planes": [{"point": [0.1, 0, 0], "normal": [1, 2, 3]}],
             "keep": "outside"},
    "camera": {"azimuth": 33.3, "elevation": -71.7, "zoom": 1.7, "ortho": true},
    "image": {"size": [40, 30], "channels": ["depth", "cost"], "show": "roots", "hierarchy": false}})");
  const Json first = tools::scene_json(tools::spelled_out(planned(bench() / "s.json")));
  std::filesystem::create_directory(bench() / "elsewhere");
  write_file(bench() / "elsewhere/t.json",
             tools::scene_json(tools::spelled_out(planned(bench() / "s.json")), bench() / "elsewhere").dump());
  EXPECT_THAT(read_file(bench() / "elsewhere/t.json"), HasSubstr("\"../ball.rho\""));
  const tools::ScenePlan again = planned(bench() / "elsewhere/t.json");
  EXPECT_EQ(again.frame.width, 40);
  EXPECT_TRUE(again.frame.channels.cost);
  EXPECT_FALSE(again.frame.use_hierarchy);
  EXPECT_EQ(again.scene.lights.at(1).color, Vec3(0.9, 0.7, 0.1) * 3.3);
  EXPECT_EQ(again.scene.lights.at(1).size, 0.25);
  EXPECT_EQ(again.scene.lights.at(1).samples, 9);
  EXPECT_EQ(again.scene.lights.at(2).size, 0.53);
  EXPECT_EQ(again.scene.lights.at(2).samples, 16);
  const std::size_t slices = again.scene.layers.size() - 2;
  EXPECT_EQ(again.scene.layers.at(slices).plane.point.z, 0.3);
  EXPECT_EQ(again.scene.layers.at(slices).threshold, (Interval<double>{0.1, 0.9}));
  EXPECT_EQ(again.scene.layers.at(slices).surface.opacity, 0.8);
  EXPECT_FALSE(again.scene.layers.at(slices).surface.lit);
  EXPECT_EQ(again.scene.layers.at(slices + 1).plane.normal, Vec3(1, 2, 3));
  EXPECT_EQ(again.scene.layers.at(slices + 1).surface.color_by->map, render::ColorMap::gray);
  EXPECT_TRUE(again.scene.layers.at(slices + 1).surface.lit);
  EXPECT_EQ(again.scene.clip->box, Box3({0.1, -9, -9}, {9, 9, 9.3}));
  EXPECT_EQ(again.scene.clip->planes.at(0).normal, Vec3(1, 2, 3));
  EXPECT_TRUE(again.scene.clip->cuts_away);
  EXPECT_FALSE(again.scene.layers.at(2).clipped);
  Json second = tools::scene_json(tools::spelled_out(again));
  second["data"] = first["data"];  // by other ways
  EXPECT_EQ(second.dump(), first.dump());
}

TEST_F(SceneDocument, says_of_what_layers_a_clip_region_leaves_nothing) {
  const auto notes_of = [&](const std::string& clip) {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [
      {"type": "isosurface", "isovalue": 100}, {"type": "mip", "clip": false}], "clip": )",
                                          clip, "}"));
    std::vector<std::string> notes;
    for (const std::string& note : planned(bench() / "s.json").notes) notes.push_back(without_folder(note));
    return notes;
  };
  EXPECT_THAT(notes_of(R"({"box": [[900, 0, 0], [901, 1, 1]]})"),
              ElementsAre("s.json: /clip: nothing of layer 0 is left"));
  EXPECT_THAT(notes_of(R"({"planes": [{"point": [0, 0, 900], "normal": [0, 0, 1]}]})"),
              ElementsAre("s.json: /clip: nothing of layer 0 is left"));
  EXPECT_THAT(notes_of(R"({"box": [[-900, -900, -900], [900, 900, 900]], "keep": "outside"})"),
              ElementsAre("s.json: /clip: nothing of layer 0 is left"));
  EXPECT_THAT(notes_of(R"({"box": [[-900, -900, -900], [900, 900, 900]]})"), ElementsAre());
}

TEST_F(SceneDocument, says_of_slices_that_pass_the_data_by_and_of_a_camera_inside) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [
    {"type": "slice", "axis": "z"}, {"type": "slice", "axis": "z", "position": 900}]})");
  EXPECT_THAT(planned(bench() / "s.json").notes,
              ElementsAre("layer 1: its plane passes the data by: nothing is shown of it"));
  const Vec3 middle = planned(bench() / "s.json").scene.layers[0].plane.point;
  write_file(
      bench() / "s.json",
      concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}, {"type": "slice", "axis": "x"}],
               "camera": {"position": [)",
             middle.x, ",", middle.y, ",", middle.z, R"(], "target": [900, 0, 0]}})"));
  EXPECT_THAT(planned(bench() / "s.json").notes, ElementsAre(testing::EndsWith("ball.rho: rays begin in it")));
}

TEST_F(SceneDocument, shows_triangles_as_a_layer_of_their_own) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "c": {"file": "cube.rho"}},
    "accuracy": "certified",
    "layers": [{"type": "isosurface", "data": "b", "isovalue": 100},
               {"type": "mesh", "data": "c", "normals": "smooth", "opacity": 0.5, "specular": 0},
               {"type": "mesh", "data": "c", "color": [1, 0, 0], "accuracy": "double"}]})");
  const tools::ScenePlan plan = planned(bench() / "s.json");
  ASSERT_EQ(plan.scene.layers.size(), 3U);
  const render::Layer& first = plan.scene.layers[1];
  EXPECT_EQ(first.mode, render::Mode::triangles);
  EXPECT_EQ(first.surface.normals, render::Normals::smooth);
  EXPECT_EQ(first.surface.opacity, 0.5);
  EXPECT_EQ(first.method, render::method_of(render::Accuracy::single)) << "triangles have no certified level";
  EXPECT_EQ(plan.scene.layers[2].method, render::method_of(render::Accuracy::twofold));
  EXPECT_EQ(plan.scene.layers[2].surface.color, Vec3(1, 0, 0));
  EXPECT_NE(first.surface.color, plan.scene.layers[0].surface.color);
  const Json spelled = tools::scene_json(tools::spelled_out(plan));
  EXPECT_EQ(spelled["layers"][1]["type"], "mesh");
  EXPECT_FALSE(spelled["layers"][1].contains("isovalue"));
}

TEST_F(SceneDocument, knows_triangles_by_the_older_type_too) {
  write_file(bench() / "s.json", R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "isosurface"}]})");
  const tools::ScenePlan plan = planned(bench() / "s.json");
  EXPECT_EQ(plan.scene.layers.at(0).mode, render::Mode::triangles);
  EXPECT_EQ(tools::scene_json(tools::spelled_out(plan))["layers"][0]["type"], "mesh");
}

TEST_F(SceneDocument, notes_lights_that_may_not_be_meant_and_surfaces_that_are_not_traced) {
  const auto notes = [&](const std::string& lights, const std::string& layer = R"("isovalue": 100)",
                         const std::string& camera = R"({"view": "-y"})") {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "isosurface", )",
                                          layer, "}], \"lights\": ", lights, ", \"camera\": ", camera, "}"));
    std::vector<std::string> said = planned(bench() / "s.json").notes;
    for (std::string& note : said) note = without_folder(note);
    return said;
  };
  const auto point = [](const char* position, const char* more = "") {
    return concat(R"([{"type": "point", "position": )", position, more, "}]");
  };
  // The ball is 23 wide; its isosurface 100 has a radius of 7.3 about (11.5, 11.5, 11.5).
  const auto is_inside = ElementsAre(HasSubstr("light 0 stands inside opaque surfaces"));
  EXPECT_THAT(notes(point("[11.5, 11.5, 11.5]")), is_inside);
  EXPECT_THAT(notes(point("[9, 12, 15]", R"(, "shadows": true)")), is_inside);
  EXPECT_THAT(notes(point("[11.5, -3, 11.5]")), testing::IsEmpty());
  EXPECT_THAT(notes(point("[11.5, 11.5, 11.5]"), R"("isovalue": 100, "opacity": 0.9)"), testing::IsEmpty())
      << "a clear surface lets it out";
  EXPECT_THAT(notes(point("[11.5, 11.5, 13]"), R"("isovalue": 100)",
                    R"({"position": [11.5, 10, 11.5], "target": [11.5, 11.5, 11.5]})"),
              ElementsAre(HasSubstr("the camera stands inside")))
      << "the eye is there too";
  // Looking along +y.
  const auto is_behind = ElementsAre(HasSubstr("light 0 shines from behind what is looked at"));
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0.05, 1, 0]}])"), is_behind);
  EXPECT_THAT(notes(point("[11.5, 90, 11.5]")), is_behind);
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0.5, 1, 0]}])"), testing::IsEmpty());
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0, -1, 0]}])"), testing::IsEmpty());
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0, -1, 0], "angular_diameter": 3}])"),
              ElementsAre(HasSubstr("light 0 has a size, which only shadows show")));
  EXPECT_THAT(notes("[]"), testing::IsEmpty());
  EXPECT_THAT(notes("[]", R"("isovalue": 100, "ambient": 0)"), ElementsAre(HasSubstr("no light shines")));
  EXPECT_THAT(notes(R"([{"type": "head"}])", R"("isovalue": 100, "opacity": 0)"),
              ElementsAre("s.json: /layers/0/opacity: is 0: the surface is not traced"));
  EXPECT_THAT(notes(R"([{"type": "head"}])", R"("isovalue": 100, "opacity": 1)"), testing::IsEmpty());
}

TEST_F(SceneDocument, places_lights_by_directions_and_by_angles_from_world_and_camera) {
  const auto direction = [&](const std::string& light, const std::string& camera) {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "isosurface"}],
      "lights": [{"type": "directional", )",
                                          light, R"(}], "camera": )", camera, "}"));
    return planned(bench() / "s.json").scene.lights.at(0).place;
  };
  const auto is_near = [](const Vec3& a, const Vec3& b) { return (a - b).length() < 1e-12; };
  // From its right, from above, and from the eye itself, seen from +x with z up: right is +y.
  EXPECT_TRUE(is_near(direction(R"("azimuth": 90, "from": "camera")", R"({"view": "+x"})"), {0, 1, 0}));
  EXPECT_TRUE(is_near(direction(R"("elevation": 90, "from": "camera")", R"({"view": "+x"})"), {0, 0, 1}));
  EXPECT_TRUE(is_near(direction(R"("azimuth": 0, "from": "camera")", R"({"view": "+x"})"), {1, 0, 0}));
  EXPECT_TRUE(is_near(direction(R"("azimuth": 90)", R"({"view": "-y"})"), {1, 0, 0}));
  EXPECT_TRUE(is_near(direction(R"("azimuth": 0)", R"({"view": "+x"})"), {0, -1, 0}));
  EXPECT_EQ(direction(R"("direction": [1, 2, 3])", R"({"view": "+x"})"), Vec3(1, 2, 3));
}

TEST_F(SceneDocument, fits_occlusion_and_fog_to_what_is_shown_where_they_say_no_distance) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}],
    "effects": {"ambient_occlusion": {}, "fog": {}}, "camera": {"view": "-y", "ortho": true},
    "image": {"background": [0.25, 0.5, 1]}})");
  const tools::ScenePlan plan = planned(bench() / "s.json");
  const Box3 box = plan.volumes[0].bounds();
  EXPECT_DOUBLE_EQ(plan.scene.occlusion.radius, box.size().length() / 10);
  EXPECT_EQ(plan.scene.occlusion.samples, 16);
  ASSERT_TRUE(plan.scene.fog);
  EXPECT_EQ(plan.scene.fog->color, Vec3(0.25, 0.5, 1));
  const double to_front = box.min.y - plan.scene.camera.position.y;
  EXPECT_NEAR(plan.scene.fog->range.lo, to_front, 1e-9);
  EXPECT_NEAR(plan.scene.fog->range.hi, to_front + 2 * box.size().y, 1e-9);
}

TEST_F(SceneDocument, without_lights_has_one_white_light_at_the_eye_and_no_effects) {
  write_file(bench() / "s.json", with("accuracy", "\"double\""));
  const tools::ScenePlan plan = planned(bench() / "s.json");
  ASSERT_EQ(plan.scene.lights.size(), 1U);
  EXPECT_EQ(plan.scene.lights[0].kind, render::Light::Kind::head);
  EXPECT_EQ(plan.scene.lights[0].color, Vec3(1, 1, 1));
  EXPECT_EQ(plan.scene.occlusion.radius, 0);
  EXPECT_FALSE(plan.scene.fog);
  EXPECT_FALSE(tools::scene_json(tools::spelled_out(plan)).contains("lights"));
  EXPECT_FALSE(tools::scene_json(tools::spelled_out(plan)).contains("effects"));
  write_file(bench() / "s.json", with("lights", R"([{"type": "head"}, {"type": "head", "intensity": 0}])"));
  EXPECT_THAT(planned(bench() / "s.json").notes, ElementsAre("light 1 shines with no intensity: not traced"));
}

TEST(SceneSchema, is_the_published_one) {
  EXPECT_EQ(read_file(RHORAY_SOURCE_DIR "/data/scenes/scene.schema.json"), tools::scene_schema_text())
      << "rhoray render --scene-schema > data/scenes/scene.schema.json";
  EXPECT_THAT(read_file(RHORAY_SOURCE_DIR "/data/scenes/README.md"), HasSubstr(tools::scene_reference()))
      << "rhoray render --scene-help prints the tables";
}

TEST(SceneSchema, knows_every_key_and_nothing_else) {
  const Json schema = tools::scene_schema();
  for (const auto& row : tools::scene_rows()) EXPECT_TRUE(schema["properties"].contains(row.key)) << row.key;
  EXPECT_EQ(schema["required"], Json({"data", "layers"}));
  const Json& kinds = schema["properties"]["layers"]["items"]["oneOf"];
  ASSERT_EQ(kinds.size(), tools::layer_kinds().size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_EQ(kinds[i]["properties"]["type"]["const"], tools::layer_kinds()[i].word);
    EXPECT_EQ(kinds[i]["properties"].size(), tools::layer_kinds()[i].rows.size() + 1);
  }
  EXPECT_FALSE(kinds[1]["properties"].contains("isovalue"));
  const Json& lights = schema["properties"]["lights"]["items"]["oneOf"];
  ASSERT_EQ(lights.size(), tools::light_kinds().size());
  EXPECT_EQ(lights[2]["required"], Json({"type", "position"}));
  EXPECT_EQ(schema["properties"]["camera"]["properties"]["elevation"]["maximum"], 90);
}

}  // namespace
}  // namespace rhoray::tests
