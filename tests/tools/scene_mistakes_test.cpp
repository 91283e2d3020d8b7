#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/scene_documents.h"

namespace rhoray::tests {
namespace {

using testing::ElementsAre;

struct Mistake {
  std::string document;
  std::string fact;
  std::string hint = "";
  int exit_code = 4;
};

std::vector<Mistake> mistakes() {
  const std::string isovalue = "expected a number, \"auto\" or a percentile such as \"p95\"";
  const std::string maps =
      "\"viridis\", \"viridis_r\", \"magma\", \"magma_r\", \"inferno\", \"inferno_r\", "
      "\"plasma\", \"plasma_r\", \"cividis\", \"cividis_r\", \"gray\", \"gray_r\", "
      "\"cubehelix\", \"cubehelix_r\", \"turbo\", \"turbo_r\", \"coolwarm\", \"coolwarm_r\"";
  const std::string color = "expected a colour: a CSS name, \"#rrggbb\", or linear [r, g, b] from 0 to 1";
  const std::string size = "expected [width, height] from 1 to 65536, or \"720p\", \"1080p\", \"4k\"";
  const std::string views = R"(expected one of "iso", "front", "back", "left", "right", "top", "bottom", )"
                            R"("+x", "-x", "+y", "-y", "+z", "-z")";
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
       "s.json: /data/a/file: duplicate key"},
      {R"({"layers": [], "layers": []})", "s.json: /layers: duplicate key"},
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
      {with("data", R"({"a/b": {}})"), "s.json: /data/a~1b: has no \"file\"; expected a file name"},
      {with("data", R"({"ball": {"file": ""}})"), "s.json: /data/ball/file: found \"\"; expected a file name"},
      {with("data", R"({"ball": {"file": "ball.rho\u0000.txt"}})"),
       "s.json: /data/ball/file: found \"ball.rho\\u0000.txt\"; expected a file name without the character NUL"},
      {with("data", R"({"ball": {"file": "bal.rho"}})"), "s.json: /data/ball/file: bal.rho: no such file",
       "did you mean ball.rho?", 3},
      {with("data", R"({"ball": {"file": "ball.rho", "field": "bone"}})"),
       "s.json: /data/ball/field: ball.rho: no field 'bone'; it has 'ball'"},
      {with("data", R"({"ball": {"file": "box.rho", "field": "heigth"}})"),
       "s.json: /data/ball/field: box.rho: no field 'heigth'; it has 'height', 'length'", "did you mean height?"},
      {with("data", R"({"ball": {"file": "ball.rho", "field": 1}})"),
       "s.json: /data/ball/field: found 1; expected a string"},

      // layers
      {with("layers", "[]"), "s.json: /layers: found []; expected an array of 1 to 254 layers"},
      {with("layers", "{}"), "s.json: /layers: found an object; expected an array of 1 to 254 layers"},
      {with("layers", "[7]"), "s.json: /layers/0: found 7; expected an object"},
      {with("layers", "[{}]"),
       "s.json: /layers/0: has no \"type\"; expected one of \"isosurface\", \"mip\", \"triangles\", \"boundary\", "
       "\"slice\""},
      {with("layers", R"([{"type": "isosurfce"}])"),
       "s.json: /layers/0/type: found \"isosurfce\"; expected one of \"isosurface\", \"mip\", \"triangles\", "
       "\"boundary\", \"slice\"",
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
       "auto chooses one from the histogram"},
      {with("layers", R"([{"type": "isosurface", "isovalue": [900, -4]}])"),
       "s.json: /layers/0/isovalue/0: isovalue 900 is outside the range 0 to 237 of field 'ball'",
       "auto chooses one from the histogram"},
      {with_layer(R"("range": [0, 10])"), "s.json: /layers/1/range: on a surface, needs \"color_by\""},
      {with_layer(R"("colormap": "gray")"), "s.json: /layers/1/colormap: needs \"color_by\""},
      {with_layer(R"("color_by": "bal")"), "s.json: /layers/1/color_by: no field 'bal'; available: 'ball'",
       "did you mean ball?"},
      // textures
      {with_texture(R"("texture": 3)"), "s.json: /layers/0/texture: found 3; expected a string"},
      {with_texture(R"("texture": "phto")"),
       "s.json: /layers/0/texture: found \"phto\"; expected one of \"ball\", \"photo\"", "did you mean photo?"},
      {with_texture(R"("texture": "ball")"), "s.json: /layers/0/texture: ball.rho: holds a grid; expected colours",
       "a folder of pictures, .nrrd, .mha, .nii, .npy and .vti can hold them; `rhoray pack --color` packs them", 7},
      {with_texture(R"("texture": "photo")", R"({"file": "ball.raw"})"),
       "s.json: /layers/0/texture: ball.raw: unsupported file type \".raw\"; expected colours",
       "a folder of pictures, .nrrd, .mha, .nii, .npy and .vti can hold them", 7},
      {with_texture(R"("texture": "photo")", R"({"file": "foto.rho"})"),
       "s.json: /data/photo/file: foto.rho: no such file", "did you mean photo.rho?", 3},
      {with_texture(R"("texture": "photo")", R"({"file": "photo.rho", "field": "red"})"),
       "s.json: /layers/0/texture: photo.rho: field 'red': a file of colours has no fields"},
      {with_texture(R"("texture": "photo", "color_by": "ball")"),
       "s.json: /layers/0/texture: \"color_by\" is also given; expected only one of the two"},
      {R"({"data": {"photo": {"file": "photo.rho"}}, "layers": [{"type": "isosurface"}]})",
       "s.json: /data/photo/file: photo.rho: holds colours; expected a grid, a mesh or a surface",
       "use it as a texture of other data: --texture FILE, or the key \"texture\" of a scene's layer", 7},
      {with("layers", R"([{"type": "mip", "texture": "photo"}])"),
       "s.json: /layers/0/texture: found in a layer of type \"mip\"; expected in one of type \"isosurface\""},
      {with_layer(R"("color_by": "ball", "colormap": "viridsi")"),
       "s.json: /layers/1/colormap: found \"viridsi\"; expected one of " + maps, "did you mean viridis?"},
      {with_layer(R"("normals": "flat")"),
       "s.json: /layers/1/normals: 'flat' applies only to meshes, and ball.rho is a grid",
       "use exact, the gradient of the trilinear field, or smooth"},
      {with("layers", R"([{"type": "mip", "normals": "flat"}])"),
       "s.json: /layers/0/normals: found in a layer of type \"mip\"; expected in one of type \"isosurface\""},
      {with("layers", R"([{"type": "mip", "isovalue": 4}])"),
       "s.json: /layers/0/isovalue: found in a layer of type \"mip\"; expected in one of type \"isosurface\""},
      {with("layers", R"([{"type": "mip", "range": [9, 4]}])"),
       "s.json: /layers/0/range: found [9,4]; expected two numbers [a, b] with a below b"},
      {with_layer(R"("color": "redd")"), "s.json: /layers/1/color: found \"redd\"; " + color},
      {with_layer(R"("color": [0, 1, 2])"), "s.json: /layers/1/color: found [0,1,2]; " + color},
      {with_layer(R"("specular": 1.5)"), "s.json: /layers/1/specular: found 1.5; expected a number from 0 to 1"},
      {with_layer(R"("shininess": 0)"), "s.json: /layers/1/shininess: found 0; expected a number from 1 to 10000"},
      {with_layer(R"("ambient": {"a": 1})"),
       "s.json: /layers/1/ambient: found an object; expected a number from 0 to 1"},
      {with_layer(R"("accuracy": "exact", "method": "paper")"),
       "s.json: /layers/1/method: \"accuracy\" is also given; expected only one of the two"},
      {with_layer(R"("method": "papr")"),
       "s.json: /layers/1/method: found 'papr'; expected one of bracketed[:float|:double], paper[:float|:double], "
       "sampled:STEP[+linear|+bisect]",
       "did you mean paper?"},

      // triangles
      {with("layers", R"([{"type": "triangles"}])"),
       "s.json: /layers/0/data: ball.rho: is a grid; expected a packed surface of triangles",
       "show its isosurfaces with a layer of type \"isosurface\""},
      {R"({"data": {"b": {"file": "box.rho"}}, "layers": [{"type": "triangles"}]})",
       "s.json: /layers/0/data: box.rho: is a mesh of tetrahedra; expected a packed surface of triangles",
       "show its isosurfaces with a layer of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho", "field": "a"}}, "layers": [{"type": "triangles"}]})",
       "s.json: /data/c/field: cube.rho: no field 'a'; a surface has no fields"},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "triangles", "isovalue": 1}]})",
       "s.json: /layers/0/isovalue: found in a layer of type \"triangles\"; expected in one of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "triangles", "color_by": "a"}]})",
       "s.json: /layers/0/color_by: found in a layer of type \"triangles\"; expected in one of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "triangles", "normals": "exact"}]})",
       "s.json: /layers/0/normals: found \"exact\"; expected one of \"flat\", \"smooth\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "triangles", "accuracy": "exact"}]})",
       "s.json: /layers/0: \"accuracy\": found 'exact'; expected float or double for cube.rho, which holds triangles"},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "mip"}]})",
       "s.json: /layers/0: \"type\": needs a field, and cube.rho holds only triangles"},

      // slices
      {with("layers", R"([{"type": "slice"}])"),
       "s.json: /layers/0: has no plane; expected \"axis\", or \"point\" and \"normal\""},
      {with("layers", R"([{"type": "slice", "point": [0, 0, 0]}])"),
       "s.json: /layers/0: has no plane; expected \"axis\", or \"point\" and \"normal\""},
      {with("layers", R"([{"type": "slice", "axis": "w"}])"),
       "s.json: /layers/0/axis: found \"w\"; expected one of \"x\", \"y\", \"z\"", "did you mean x?"},
      {with("layers", R"([{"type": "slice", "position": 4, "normal": [0, 0, 1]}])"),
       "s.json: /layers/0/position: needs \"axis\""},
      {with("layers", R"([{"type": "slice", "axis": "x", "normal": [0, 0, 1]}])"),
       "s.json: /layers/0/axis: \"point\" or \"normal\" is also given; expected only one of the two"},
      {with("layers", R"([{"type": "slice", "normal": [0, 0, 0]}])"),
       "s.json: /layers/0/normal: found [0,0,0]; expected three numbers [x, y, z], not all 0"},
      {with("layers", R"([{"type": "slice", "axis": "x", "threshold": [3, 3]}])"),
       "s.json: /layers/0/threshold: found [3,3]; expected two numbers [a, b] with a below b"},
      {with("layers", R"([{"type": "slice", "axis": "x", "colormap": "grey"}])"),
       "s.json: /layers/0/colormap: found \"grey\"; expected one of " + maps, "did you mean gray?"},
      {with("layers", R"([{"type": "slice", "axis": "x", "isovalue": 4}])"),
       "s.json: /layers/0/isovalue: found in a layer of type \"slice\"; expected in one of type \"isosurface\""},
      {R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "slice", "axis": "x"}]})",
       "s.json: /layers/0: \"type\": needs a field, and cube.rho holds only triangles"},

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
       "s.json: /lights/0/direction: \"elevation\" is also given; expected only one of the two"},
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
       "s.json: /clip/box: found [[0,0,0],[1,0,1]]; expected two corners [[x, y, z], [x, y, z]]; each coordinate of "
       "the first is below that of the second"},
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
      {with("camera", R"({"position": [1e308, 0, 0]})"),
       "s.json: /camera: the camera is too far from its target; expected a distance below 1e154"},
      {with("camera", "[]"), "s.json: /camera: found []; expected an object"},
      {with("camera", R"({"view": "nowhere"})"), "s.json: /camera/view: found \"nowhere\"; " + views},
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
      {with("image", R"({"background": "#12345"})"),
       "s.json: /image/background: found \"#12345\"; expected \"none\", or" +
           color.substr(std::string("expected").size())},
      {with("image", R"({"channels": "depth"})"),
       "s.json: /image/channels: found \"depth\"; expected an array of " + channels},
      {with("image", R"({"channels": ["depht"]})"),
       "s.json: /image/channels/0: found \"depht\"; expected one of " + channels, "did you mean depth?"},
      {with("image", R"({"channels": ["cost", "cost"]})"),
       "s.json: /image/channels/1: found \"cost\"; expected each word once"},
      {with("image", R"({"channels": ["error"]})"),
       "s.json: /image/channels: the channel 'error' needs accuracy certified or exact"},
      {with("image", R"({"show": "error"})"),
       "s.json: /image/show: the channel 'error' needs accuracy certified or exact"},
      {with("image", R"({"antialias": 65})"),
       "s.json: /image/antialias: found 65; expected a whole number from 1 to 64"},

      // annotations
      {with("annotations", "true"), "s.json: /annotations: found true; expected an object"},
      {with("annotations", R"({"axes": "left"})"),
       "s.json: /annotations/axes: found \"left\"; expected true, false or an object"},
      {with("annotations", R"({"axes": {"corner": "lfet"}})"),
       "s.json: /annotations/axes/corner: found \"lfet\"; expected one of \"left\", \"right\"", "did you mean left?"},
      {with("annotations", R"({"box": {}})"), "s.json: /annotations/box: found an object; expected true or false"},
      {with("annotations", R"({"caption": ""})"),
       "s.json: /annotations/caption: found \"\"; expected a string of 1 to 2000 characters"},
      {with("annotations", concat(R"({"caption": ")", std::string(2001, 'a'), "\"}")),
       concat("s.json: /annotations/caption: found \"", std::string(37, 'a'),
              "...\"; expected a string of 1 to 2000 characters")},
      {with("annotations", concat(R"({"colorbar": {"title": ")", std::string(2001, 'a'), "\"}}")),
       concat("s.json: /annotations/colorbar/title: found \"", std::string(37, 'a'),
              "...\"; expected a string of 1 to 2000 characters")},
      {with("annotations", R"({"colorbar": {"position": "top"}})"),
       "s.json: /annotations/colorbar/position: found \"top\"; expected one of \"left\", \"right\""},
      {with("annotations", R"({"colorbar": true})"),
       "s.json: /annotations/colorbar: nothing here is coloured by a field"},
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
  std::string equal = "100";
  for (int i = 1; i < 255; ++i) equal += ",100";
  EXPECT_EQ(answer_to(with_layer(concat("\"isovalue\": [", equal, "]"))).fact,
            "s.json: /layers: more than 254 layers and isovalues");
}

/// The library looks for each key among all before it: these took more than a minute.
TEST_F(SceneDocument, may_have_a_hundred_thousand_keys_in_one_object) {
  std::string text = with("accuracy", "\"double\"");
  text.pop_back();
  for (int i = 0; i < 100'000; ++i) text += concat(", \"key ", i, "\": 0");
  EXPECT_EQ(render::read_scene(text + "}", "s.json", bench().path()).warnings.size(), 100'000U);
  try {
    render::read_scene(text + ", \"key 70000\": 1}", "s.json", bench().path());
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "s.json: /key 70000: duplicate key");
  }
}

TEST_F(SceneDocument, warns_of_unknown_keys_with_the_nearest_one) {
  EXPECT_THAT(answer_to(with("camera", R"({"zomm": 2})")).warnings,
              ElementsAre("s.json: /camera/zomm: unknown key, ignored; did you mean zoom?"));
  EXPECT_THAT(answer_to(with("effects", R"({"fogg": {}})")).warnings,
              ElementsAre("s.json: /effects/fogg: unknown key, ignored; did you mean fog?"));
  EXPECT_THAT(answer_to(with("flamingo", "1")).warnings, ElementsAre("s.json: /flamingo: unknown key, ignored"));
  const Answer layer = answer_to(with_layer(R"("isovlaue": 3)"));
  EXPECT_THAT(layer.warnings, ElementsAre("s.json: /layers/1/isovlaue: unknown key, ignored; did you mean isovalue?"));
  EXPECT_EQ(layer.fact, "");
}

}  // namespace
}  // namespace rhoray::tests
