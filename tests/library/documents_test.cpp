// Scene documents as text, and the files that they name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <tuple>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A folder with a grid and a mesh; `outside` is beside it.
class Documents : public testing::Test {
 protected:
  Documents() {
    std::filesystem::create_directories(folder_ / "in/below");
    gyroid_grid({.file = folder_ / "in/grid.rho"});
    ball_mesh(3, {.file = folder_ / "in/below/mesh.rho"});
    octahedron({.file = folder_ / "outside.rho"});
  }
  std::filesystem::path inside() const { return folder_ / "in"; }
  ResolvedScene resolved(const std::string& text) const {
    return resolve(SceneDocument::parse(text), files_in(inside()));
  }

  TemporaryFolder folder_;
};

std::string document(const std::string& data, const std::string& layers, const std::string& more = "") {
  return R"({"data": {"d": )" + data + R"(}, "layers": [)" + layers + "]" + more + "}";
}
std::string layer_with(const std::string& type, const std::string& method) {
  return R"({"type": ")" + type + R"(", "method": ")" + method + R"("})";
}
std::string of_grid(const std::string& layers, const std::string& more = "") {
  return document(R"({"file": "grid.rho"})", layers, more);
}

TEST_F(Documents, name_files_relative_to_the_folder_that_opens_them) {
  const ResolvedScene grid = resolved(of_grid(R"({"type": "isosurface", "isovalue": 0.25})"));
  ASSERT_EQ(grid.scene.layers.size(), 1U);
  EXPECT_EQ(std::get<Isosurface>(grid.scene.layers[0].show).isovalue, 0.25);
  EXPECT_EQ(grid.scene.layers[0].data.bounds(), gyroid_grid().bounds());
  EXPECT_TRUE(grid.scene.camera.has_value());
  const ResolvedScene mesh = resolved(document(R"({"file": "below/mesh.rho", "field": "x"})", R"({"type": "mip"})"));
  EXPECT_EQ(mesh.scene.layers[0].field, "x");
}

TEST_F(Documents, that_are_read_from_a_file_name_files_beside_it) {
  write_file(inside() / "scene.json", of_grid(R"({"type": "mip"})"));
  // By an absolute path, and by one from the working folder.
  for (const std::filesystem::path& path :
       {inside() / "scene.json", std::filesystem::proximate(inside() / "scene.json")}) {
    const SceneDocument read = SceneDocument::read(path);
    EXPECT_EQ(resolve(read, files_in(inside())).scene.layers.size(), 1U);
  }
}

TEST_F(Documents, open_no_file_by_themselves) {
  const SceneDocument parsed =
      SceneDocument::parse(document(R"({"file": "nowhere/at/all.rho"})", R"({"type": "mip"})"));
  std::vector<std::string> asked;
  const ResolvedScene scene = resolve(parsed, [&](const std::filesystem::path& file) {
    asked.push_back(file.string());
    return gyroid_grid();
  });
  EXPECT_THAT(asked, ElementsAre("nowhere/at/all.rho"));
  EXPECT_EQ(scene.scene.layers.size(), 1U);
  expect_refused(ErrorCode::usage, "no function that opens data", [&] { resolve(parsed, {}); });
}

TEST_F(Documents, do_not_lead_out_of_a_folder) {
  std::filesystem::create_symlink(folder_ / "outside.rho", inside() / "link.rho");
  std::filesystem::create_directory_symlink(folder_.path(), inside() / "up");
  std::filesystem::create_symlink(inside() / "grid.rho", inside() / "below/within.rho");
  const OpenData open = files_in(inside());
  for (const std::string& file :
       {std::string("../outside.rho"), std::string("below/../../outside.rho"), std::string("link.rho"),
        std::string("up/outside.rho"), (folder_ / "outside.rho").string(), std::string("/etc/passwd"),
        std::string(".."), std::string("up/../outside.rho"), folder_.path().string() + "/in2/grid.rho"})
    expect_refused(ErrorCode::usage, "is outside of", [&] { open(file); });
  EXPECT_EQ(open("below/within.rho").kind(), DataKind::grid);
  EXPECT_EQ(open("below/../grid.rho").kind(), DataKind::grid);
  EXPECT_EQ(open((inside() / "grid.rho").string()).kind(), DataKind::grid);
  expect_refused(ErrorCode::unreadable, "none.rho", [&] { open("none.rho"); });
  expect_refused(ErrorCode::unreadable, "nothing", [&] { files_in(folder_ / "nothing"); });
  expect_refused(ErrorCode::unreadable, "outside.rho", [&] { files_in(folder_ / "outside.rho"); });
}

TEST_F(Documents, that_are_no_documents_are_refused_with_the_place) {
  const auto refuse = [](const std::string& words, const std::string& text) {
    expect_refused(ErrorCode::invalid, words, [&] { SceneDocument::parse(text, "s"); });
  };
  refuse("s, line 1", "");
  refuse("s: ", "[]");
  refuse("line 1", "{\"data\": }");
  refuse("data", "{}");
  refuse("/layers/0/isovalue: found \"hihg\"", of_grid(R"({"type": "isosurface", "isovalue": "hihg"})"));
  refuse("/layers/0/type", of_grid(R"({"type": "surface"})"));
  refuse("/layers/0/opacity: found 2", of_grid(R"({"type": "isosurface", "opacity": 2})"));
  refuse("duplicate key", of_grid(R"({"type": "mip", "type": "mip"})"));
  refuse("", of_grid(std::string(40, '[') + std::string(40, ']')));
  refuse("4 MiB", of_grid(R"({"type": "mip"})") + std::string(5 << 20, ' '));
  expect_refused(ErrorCode::unreadable, "none.json", [&] { SceneDocument::read(inside() / "none.json"); });
  expect_refused(ErrorCode::unreadable, "is a folder; expected a document", [&] { SceneDocument::read(inside()); });
  expect_refused(ErrorCode::unreadable, "{}: no such file", [] { SceneDocument::read("{}"); });
}

TEST_F(Documents, that_contradict_their_data_are_refused_with_the_place) {
  const auto refuse = [&](ErrorCode code, const std::string& words, const std::string& text) {
    expect_refused(code, words, [&] { resolved(text); });
  };
  refuse(ErrorCode::invalid, "/layers/0", of_grid(R"({"type": "triangles"})"));
  refuse(ErrorCode::invalid, "/layers/0", of_grid(R"({"type": "isosurface", "data": "e"})"));
  refuse(ErrorCode::invalid, "/layers/0", of_grid(R"({"type": "isosurface", "isovalue": 99})"));
  refuse(ErrorCode::invalid, "/layers/0", of_grid(R"({"type": "isosurface", "color_by": "heat"})"));
  refuse(ErrorCode::invalid, "/layers/0/method: \"accuracy\" is also given",
         of_grid(R"({"type": "isosurface", "accuracy": "exact", "method": "paper"})"));
  refuse(ErrorCode::invalid, "/clip", of_grid(R"({"type": "mip"})", R"(, "clip": {"invert": true})"));
  refuse(ErrorCode::unsupported, "labels of grids",
         document(R"({"file": "grid.rho", "label": 1})", R"({"type": "isosurface"})"));
  refuse(ErrorCode::unreadable, "none.rho", document(R"({"file": "none.rho"})", R"({"type": "mip"})"));
  refuse(ErrorCode::usage, "is outside of", document(R"({"file": "../outside.rho"})", R"({"type": "mip"})"));
  EXPECT_THROW(resolved(document(R"({"file": "grid.rho", "field": "heat"})", R"({"type": "mip"})")), Error);
}

/// The library offers fewer methods than the program.
TEST_F(Documents, with_methods_of_the_program_are_refused) {
  const std::string mesh = R"({"file": "below/mesh.rho", "field": "radius"})";
  const std::string grid = R"({"file": "grid.rho"})";
  const auto text = [](const std::string& data, const char* type, const std::string& method) {
    return document(data, layer_with(type, method));
  };
  struct Row {
    const std::string& data;
    const char* type;
    const char* method;
    std::optional<Method> expected;  ///< nothing: only the program has it
  };
  const Row rows[] = {{grid, "isosurface", "paper", Method::paper()},
                      {grid, "isosurface", "paper:float", std::nullopt},
                      {grid, "isosurface", "bracketed", Accuracy::float64},
                      {grid, "isosurface", "bracketed:float", Accuracy::float32},
                      {grid, "isosurface", "sampled:0.25+bisect", Method::sampled(0.25, true)},
                      {grid, "mip", "exact", Accuracy::float64},
                      {grid, "mip", "face", Method::paper()},
                      {grid, "mip", "face:float", std::nullopt},
                      {grid, "mip", "sampled:2", Method::sampled(2)},
                      {mesh, "isosurface", "edges", Accuracy::float64},
                      {mesh, "isosurface", "paper", Method::paper()},
                      {mesh, "isosurface", "paper:float", std::nullopt},
                      {mesh, "isosurface", "slack:1e-12", std::nullopt},
                      {mesh, "isosurface", "slack:0.01:float", std::nullopt},
                      {mesh, "isosurface", "sampled:0.5+linear", Method::sampled(0.5)},
                      {mesh, "mip", "face:float", std::nullopt}};
  for (const auto& [data, type, method, expected] : rows) {
    SCOPED_TRACE(std::string(type) + " " + method);
    if (expected)
      EXPECT_TRUE(resolved(text(data, type, method)).scene.layers[0].method == *expected);
    else
      expect_refused(ErrorCode::unsupported, "a method of the layer is in the program only",
                     [&, &data = data, &type = type, &method = method] { resolved(text(data, type, method)); });
  }
  // These belong to data of another kind.
  for (const auto& [data, type, method] : {std::tuple{grid, "isosurface", "edges"},
                                           {grid, "isosurface", "slack:0.1"},
                                           {mesh, "isosurface", "bracketed"},
                                           {grid, "mip", "paper"},
                                           {grid, "isosurface", "face"},
                                           {grid, "isosurface", "sampled:0"},
                                           {mesh, "isosurface", "slack:2"},
                                           {grid, "isosurface", "marching"}})
    expect_refused(ErrorCode::invalid, "/layers/0/method",
                   [&, &data = data, &type = type, &method = method] { resolved(text(data, type, method)); });
}

TEST_F(Documents, with_textures_are_refused) {
  expect_refused(ErrorCode::unsupported, "textures of documents are in the program only",
                 [&] { resolved(of_grid(R"({"type": "isosurface", "texture": "d"})")); });
}

TEST_F(Documents, warn_of_unknown_keys_and_note_what_is_left_out) {
  const SceneDocument odd = SceneDocument::parse(of_grid(R"({"type": "mip", "colourmap": "gray"})"));
  EXPECT_THAT(odd.warnings(), ElementsAre(HasSubstr("colormap")));
  const ResolvedScene scene = resolve(SceneDocument::parse(of_grid(R"({"type": "isosurface", "isovalue": [0, 99]})",
                                                                   R"(, "annotations": {"axes": true})")),
                                      files_in(inside()));
  EXPECT_THAT(scene.notes, testing::Contains(HasSubstr("annotations are left out")));
  EXPECT_THAT(scene.notes, testing::Contains(HasSubstr("isovalue 99 is outside the range")));
  const SceneDocument plain = SceneDocument::parse(of_grid(R"({"type": "mip"})"));
  EXPECT_THAT(plain.warnings(), IsEmpty());
  const SceneDocument copy = plain;
  EXPECT_EQ(copy.json(), plain.json());
  EXPECT_EQ(SceneDocument::parse(plain.json()).json(), plain.json());
}

TEST_F(Documents, show_the_data_that_were_opened_for_them) {
  const SceneDocument of_memory = SceneDocument::parse(
      document(R"({"file": "memory"})", R"({"type": "isosurface", "isovalue": 0.7}, {"type": "boundary"})"));
  const Dataset mesh = ball_mesh();
  const ResolvedScene made = resolve(of_memory, [&](const std::filesystem::path&) { return mesh; });
  ASSERT_EQ(made.scene.layers.size(), 2U);
  EXPECT_EQ(made.scene.layers[0].data.id(), mesh.id());
  EXPECT_EQ(made.scene.layers[0].data.path(), mesh.path());
  EXPECT_EQ(made.scene.layers[1].data.kind(), DataKind::triangles);
  expect_refused(ErrorCode::usage, "boundary of a mesh in memory", [&] { made.scene.layers[1].data.path(); });
  expect_refused(ErrorCode::usage, "in memory", [&] { to_document(made.scene, made.options); });
  made.scene.layers[0].data.save(folder_ / "saved.rho");
  EXPECT_EQ(Dataset::open(folder_ / "saved.rho").bounds(), mesh.bounds());
}

TEST_F(Documents, are_of_whole_pictures) {
  const Scene scene = certified_scene(Dataset::open(inside() / "grid.rho"), 0.1, {8, 8});
  expect_refused(ErrorCode::usage, "a document is of a whole picture", [&] {
    to_document(scene, {.size = {8, 8}, .window = Rect{0, 0, 4, 4}});
  });
}

TEST_F(Documents, of_data_in_memory_are_refused) {
  const Scene scene = certified_scene(gyroid_grid(), 0.1, {8, 8});
  expect_refused(ErrorCode::usage, "in memory", [&] { to_document(scene, {.size = {8, 8}}); });
  Scene without_camera = certified_scene(Dataset::open(inside() / "grid.rho"), 0.1, {8, 8});
  EXPECT_NO_THROW(to_document(without_camera, {.size = {8, 8}}));
  without_camera.camera.reset();
  expect_refused(ErrorCode::usage, "Scene::camera: not set", [&] { to_document(without_camera, {.size = {8, 8}}); });
}

}  // namespace
}  // namespace rhoray::tests
