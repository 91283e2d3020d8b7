#include "tests/house/include_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

void PrintTo(const Breach& breach, std::ostream* out) {
  *out << breach.file << ":" << breach.line << ": " << breach.include << " (" << breach.rule << ")";
}

namespace {

/// A small house in which every include is allowed.
class PlantedHouse {
 public:
  PlantedHouse() {
    plant("formats/grid.h", "#include <Imath/ImathVec.h>\n#include \"formats/base/box.h\"\n");
    plant("formats/base/box.h", "#pragma once\n#include <vector>\n");
    plant("formats/envelope/header.h", "#include <nlohmann/json.hpp>\n#include <xxhash.h>\n");
    plant("preprocess/pack.h", "#include \"formats/grid.h\"\n");
    plant("preprocess/import/nrrd.cpp",
          "#include <teem/nrrd.h>\n#include <vtkImageData.h>\n#include \"preprocess/pack.h\"\n");
    plant("preprocess/tetrahedralize/fill.cpp", "#include <tetgen.h>\n#include <CGAL/box.h>\n");
    plant("render/scene.h", "#include \"formats/base/box.h\"\n");
    plant("render/method.h", "");
    plant("render/march/ray.h", "#include \"formats/base/box.h\"\n");
    plant("render/cells/cubic.h", "#include \"render/march/ray.h\"\n");
    plant("render/volumes/grid.h", "#include \"formats/grid.h\"\n#include \"render/march/ray.h\"\n");
    plant("render/kernels/kernels.h", "#include \"render/volumes/grid.h\"\n#include \"render/method.h\"\n");
    plant("render/effects/diffuse.h", "#include \"render/scene.h\"\n");
    plant("render/frame/frame.cpp", "#include <tbb/parallel_for.h>\n#include \"render/effects/diffuse.h\"\n");
    plant("data/recipes/ball.cpp", "#include <Eigen/Sparse>\n#include \"preprocess/pack.h\"\n");
    plant("tools/rhoray/main.cpp", "#include <CLI/CLI.hpp>\n#include <unistd.h>\n#include \"render/scene.h\"\n");
    plant("tests/render/ray_test.cpp", "#include <gtest/gtest.h>\n#include \"render/march/ray.h\"\n");
  }

  void plant(const std::string& file, const std::string& text) {
    std::filesystem::create_directories((folder_ / file).parent_path());
    write_file(folder_ / file, text);
  }

  std::vector<Breach> breaches() const { return tests::breaches(folder_.path()); }

 private:
  TemporaryFolder folder_;
};

struct Plant {
  const char* file;
  const char* include;
  const char* rule;
};

const Plant plants[] = {{"formats/up.h", "\"preprocess/pack.h\"", "floors"},
                        {"formats/up.cpp", "\"render/scene.h\"", "floors"},
                        {"preprocess/sideways.h", "\"render/scene.h\"", "floors"},
                        {"render/sideways.cpp", "\"preprocess/pack.h\"", "floors"},
                        {"render/up.cpp", "\"tools/rhoray/main.cpp\"", "floors"},
                        {"data/recipes/up.cpp", "\"render/scene.h\"", "floors"},
                        {"preprocess/peeps.cpp", "\"formats/envelope/header.h\"", "porches"},
                        {"tools/rhoray/peeps.cpp", "\"render/march/ray.h\"", "porches"},
                        {"data/recipes/peeps.cpp", "\"preprocess/import/nrrd.cpp\"", "porches"},
                        {"render/march/heavy.h", "\"formats/grid.h\"", "rooms of render"},
                        {"render/cells/heavy.h", "\"render/volumes/grid.h\"", "rooms of render"},
                        {"render/volumes/up.h", "\"render/kernels/kernels.h\"", "rooms of render"},
                        {"render/kernels/up.h", "\"render/effects/diffuse.h\"", "rooms of render"},
                        {"render/effects/deep.h", "\"render/volumes/grid.h\"", "rooms of render"},
                        {"render/attic/new.h", "\"render/scene.h\"", "rooms of render"},
                        {"render/tetgen.cpp", "<tetgen.h>", "guests"},
                        {"formats/cgal.h", "<CGAL/box.h>", "guests"},
                        {"render/cgal.h", "<CGAL/box.h>", "guests"},
                        {"preprocess/import/cgal.cpp", "<CGAL/box.h>", "guests"},
                        {"tools/rhoray/vtk.cpp", "<vtkImageData.h>", "guests"},
                        {"preprocess/vtk.cpp", "<vtkImageData.h>", "guests"},
                        {"formats/tbb.h", "<tbb/parallel_for.h>", "guests"},
                        {"preprocess/tbb.cpp", "<tbb/parallel_for.h>", "guests"},
                        {"tools/rhoray/tbb.cpp", "<tbb/global_control.h>", "guests"},
                        {"render/pictures.cpp", "<OpenImageIO/imageio.h>", "guests"},
                        {"render/json.cpp", "<nlohmann/json.hpp>", "guests"},
                        {"render/test.h", "<gtest/gtest.h>", "guests"},
                        {"preprocess/eigen.cpp", "<Eigen/Sparse>", "guests"},
                        {"render/stranger.h", "<stranger/danger.h>", "guests"},
                        {"formats/brackets.h", "<formats/grid.h>", "guests"},
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

TEST(House, keeps_floors_porches_and_guests) {
  EXPECT_THAT(breaches(RHORAY_SOURCE_DIR), testing::IsEmpty());
}

}  // namespace
}  // namespace rhoray::tests
