#include "tests/house/include_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

void PrintTo(const Breach& breach, std::ostream* out) {
  *out << breach.file << ":" << breach.line << ": " << breach.include << " (" << breach.rule << ")";
}

namespace {

/// A small source tree in which every include is allowed.
class PlantedHouse {
 public:
  PlantedHouse() {
    plant("formats/grid.h", "#include <Imath/ImathVec.h>\n#include \"formats/base/box.h\"\n");
    plant("formats/base/box.h", "#pragma once\n#include <vector>\n");
    plant("formats/envelope/header.h", "#include <nlohmann/json.hpp>\n#include <xxhash.h>\n");
    plant("preprocess/pack.h", "#include \"formats/grid.h\"\n");
    plant("preprocess/import/volume/nrrd.cpp",
          "#include <teem/nrrd.h>\n#include <vtkImageData.h>\n#include \"preprocess/pack.h\"\n");
    plant("preprocess/workers/tetgen/fill.cpp", "#include <tetgen.h>\n#include <CGAL/box.h>\n");
    plant("preprocess/values/has_data.h", "#include \"formats/base/box.h\"\n");
    plant("render/scene.h", "#include \"formats/base/box.h\"\n");
    plant("render/method.h", "");
    plant("render/traverse/ray.h", "#include \"formats/base/box.h\"\n");
    plant("render/cell/cubic.h", "#include \"render/traverse/ray.h\"\n");
    plant("render/grid/grid.h", "#include \"formats/grid.h\"\n#include \"render/traverse/ray.h\"\n");
    plant("render/dataset/loaded_dataset.h", "#include \"render/grid/grid.h\"\n");
    plant("render/query/kernels.h", "#include \"render/dataset/loaded_dataset.h\"\n#include \"render/method.h\"\n");
    plant("render/grid/intersectors.h", "#include \"render/query/kernels.h\"\n");
    plant("render/shade/diffuse.h", "#include \"render/scene.h\"\n");
    plant("render/frame/frame.cpp", "#include <tbb/parallel_for.h>\n#include \"render/shade/diffuse.h\"\n");
    plant("data/recipes/ball.cpp", "#include <CLI/CLI.hpp>\n#include <Eigen/Sparse>\n#include \"preprocess/pack.h\"\n");
    plant("tools/rhoray/main.cpp", "#include <unistd.h>\n#include \"render/scene.h\"\n");
    plant("tools/pictures/canvas.h", "#include \"render/scene.h\"\n");
    plant("tools/analysis/results.h", "#include \"tools/pictures/canvas.h\"\n");
    plant("tools/rhoray/options.h", "#include \"tools/analysis/results.h\"\n");
    plant("tools/library/rhoray/types.h", "#include <vector>\n");
    plant("tools/library/scene.cpp",
          "#include \"render/scene.h\"\n#include \"rhoray/types.h\"\n#include \"rhoray/version.h\"\n");
    plant("tools/library/examples/picture.cpp", "#include <rhoray/rhoray.h>\n");
    plant("tests/render/ray_test.cpp", "#include <gtest/gtest.h>\n#include \"render/traverse/ray.h\"\n");
  }

  void plant(const std::string& file, const std::string& text) {
    std::filesystem::create_directories((folder_ / file).parent_path());
    write_file(folder_ / file, text);
  }

  std::vector<Breach> breaches() const { return tests::breaches(folder_.path()); }
  std::vector<std::string> circles() const { return tests::circles(folder_.path()); }

 private:
  TemporaryFolder folder_;
};

struct Plant {
  const char* file;
  const char* include;
  const char* rule;
};

const Plant plants[] = {{"formats/up.h", "\"preprocess/pack.h\"", "rooms"},
                        {"formats/up.cpp", "\"render/scene.h\"", "rooms"},
                        {"preprocess/sideways.h", "\"render/scene.h\"", "rooms"},
                        {"render/sideways.cpp", "\"preprocess/pack.h\"", "rooms"},
                        {"render/up.cpp", "\"tools/rhoray/main.cpp\"", "rooms"},
                        {"data/recipes/up.cpp", "\"render/scene.h\"", "rooms"},
                        {"preprocess/inside.cpp", "\"formats/envelope/header.h\"", "public headers"},
                        {"tools/rhoray/inside.cpp", "\"render/traverse/ray.h\"", "public headers"},
                        {"data/recipes/inside.cpp", "\"preprocess/import/volume/nrrd.cpp\"", "public headers"},
                        {"render/traverse/heavy.h", "\"formats/grid.h\"", "layers"},
                        {"render/cell/heavy.h", "\"render/grid/grid.h\"", "layers"},
                        {"render/grid/up.h", "\"render/query/kernels.h\"", "layers"},
                        {"render/grid/beside.h", "\"render/grid/intersectors.h\"", "layers"},
                        {"render/query/up.h", "\"render/shade/diffuse.h\"", "layers"},
                        {"render/shade/deep.h", "\"render/grid/grid.h\"", "layers"},
                        {"render/attic/new.h", "\"render/scene.h\"", "layers"},
                        {"preprocess/values/up.h", "\"preprocess/import/volume/nrrd.cpp\"", "layers"},
                        {"preprocess/attic/new.h", "\"preprocess/pack.h\"", "layers"},
                        {"tools/analysis/up.cpp", "\"tools/rhoray/options.h\"", "layers"},
                        {"tools/pictures/up.h", "\"tools/analysis/results.h\"", "layers"},
                        {"tools/view/up.cpp", "\"tools/rhoray/options.h\"", "layers"},
                        {"tools/library/rhoray/deep.h", "\"formats/grid.h\"", "layers"},
                        {"tools/library/up.cpp", "\"tools/rhoray/options.h\"", "layers"},
                        {"tools/attic/new.h", "\"tools/pictures/canvas.h\"", "layers"},
                        {"render/tetgen.cpp", "<tetgen.h>", "third-party"},
                        {"formats/cgal.h", "<CGAL/box.h>", "third-party"},
                        {"render/cgal.h", "<CGAL/box.h>", "third-party"},
                        {"preprocess/import/cgal.cpp", "<CGAL/box.h>", "third-party"},
                        {"tools/rhoray/vtk.cpp", "<vtkImageData.h>", "third-party"},
                        {"preprocess/vtk.cpp", "<vtkImageData.h>", "third-party"},
                        {"formats/tbb.h", "<tbb/parallel_for.h>", "third-party"},
                        {"preprocess/tbb.cpp", "<tbb/parallel_for.h>", "third-party"},
                        {"tools/rhoray/tbb.cpp", "<tbb/global_control.h>", "third-party"},
                        {"render/pictures.cpp", "<OpenImageIO/imageio.h>", "third-party"},
                        {"render/json.cpp", "<nlohmann/json.hpp>", "third-party"},
                        {"render/test.h", "<gtest/gtest.h>", "third-party"},
                        {"preprocess/eigen.cpp", "<Eigen/Sparse>", "third-party"},
                        {"render/stranger.h", "<stranger/danger.h>", "third-party"},
                        {"tools/library/rhoray/heavy.h", "<nlohmann/json.hpp>", "third-party"},
                        {"tools/library/brackets.cpp", "<rhoray/rhoray.h>", "third-party"},
                        {"formats/brackets.h", "<formats/grid.h>", "third-party"},
                        {"formats/relative.cpp", "\"grid.h\"", "names"},
                        {"formats/ghost.cpp", "\"formats/ghost.h\"", "names"}};

TEST(IncludeRules, says_nothing_of_a_house_in_order) {
  EXPECT_THAT(PlantedHouse().breaches(), testing::IsEmpty());
}

TEST(IncludeRules, names_file_line_include_and_rule_of_every_planted_breach) {
  for (const Plant& plant : plants) {
    SCOPED_TRACE(plant.file);
    PlantedHouse house;
    house.plant(plant.file, std::string("#pragma once\n  #  include ") + plant.include + "  // why\n");
    const std::vector<Breach> found = house.breaches();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].file, plant.file);
    EXPECT_EQ(found[0].line, 2);
    EXPECT_EQ(found[0].include, plant.include);
    EXPECT_EQ(found[0].rule, plant.rule);
  }
}

TEST(IncludeRules, find_every_circle_of_units) {
  PlantedHouse house;
  EXPECT_THAT(house.circles(), testing::IsEmpty());
  house.plant("formats/a.h", "");
  house.plant("formats/a.cpp", "#include \"formats/a.h\"\n#include \"formats/b.h\"\n");
  house.plant("formats/b.h", "#include \"formats/c.h\"\n");
  house.plant("formats/c.h", "");
  EXPECT_THAT(house.circles(), testing::IsEmpty());
  house.plant("formats/c.cpp", "#include \"formats/a.h\"\n");
  house.plant("render/x.h", "#include \"render/y.h\"\n");
  house.plant("render/y.cpp", "#include \"render/x.h\"\n");
  house.plant("render/y.h", "");
  EXPECT_THAT(house.circles(), testing::ElementsAre("formats/a formats/b formats/c", "render/x render/y"));
}

TEST(House, keeps_the_include_rules) {
  EXPECT_THAT(breaches(RHORAY_SOURCE_DIR), testing::IsEmpty());
}

TEST(House, has_no_units_that_include_each_other_in_a_circle) {
  EXPECT_THAT(circles(RHORAY_SOURCE_DIR), testing::IsEmpty());
}

}  // namespace
}  // namespace rhoray::tests
