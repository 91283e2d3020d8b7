#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "data/recipes/marschner_lobb.h"
#include "data/recipes/potential.h"
#include "data/recipes/test_volumes.h"
#include "data/recipes/torso_ct.h"
#include "data/recipes/torso_photo.h"
#include "data/recipes/torso_scene.h"
#include "data/recipes/torso_surface.h"
#include "formats/base/error.h"
#include "preprocess/import_mesh.h"

namespace {

using namespace rhoray;

struct Output {
  std::string path;
  bool replace_existing = false;
};

void add_output(CLI::App& command, Output& output, const std::string& what) {
  command.add_option("-o,--output", output.path, what)->required();
  command.add_flag("--force", output.replace_existing, "Overwrite existing files");
}

/// "512x512x1734"
Index3 parse_size(const std::string& text) {
  Index3 size;
  const char *at = text.data(), *const end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [next, error] = std::from_chars(at, end, size[axis]);
    const bool separated = axis == 2 ? next == end : next != end && *next == 'x';
    if (error != std::errc{} || !separated)
      throw Error(ErrorCode::usage, concat("size \"", text, "\"; expected three numbers like 512x512x1734"));
    at = next + (axis == 2 ? 0 : 1);
  }
  return size;
}

void add_torso_surface(CLI::App& program) {
  static Output output;
  static std::uint64_t cell_count = 100'000;
  static bool each_as_ply = false;
  CLI::App* command =
      program.add_subcommand("torso-surface", "Skin, heart and lungs as closed surfaces, with target sizes");
  add_output(*command, output, "Surface to write (.smesh); the sizes go beside it (.mtr)");
  command->add_option("--cells", cell_count, "Target number of tetrahedra, reached within a quarter")
      ->capture_default_str();
  command->add_flag("--ply", each_as_ply, "Write each surface as .ply as well");
  command->footer(
      "Example:\n  rhoray-recipes torso-surface -o torso.smesh --cells 100000\n"
      "  rhoray tetrahedralize torso.smesh -o torso.vtu --quality 1.4");
  command->callback([] {
    recipes::write_torso_surface(recipes::make_torso_surface(cell_count), output.path, each_as_ply,
                                 output.replace_existing);
  });
}

void add_torso_potential(CLI::App& program) {
  static Output output;
  static std::string mesh_path;
  static recipes::Conductivities conductivities;
  const Vec3 moment = 20.0 * recipes::torso::heart_axis(), at = recipes::torso::heart_centre;
  static recipes::Dipole dipole{
      .at_mm = {at.x, at.y, at.z}, .moment_ma_mm = {moment.x, moment.y, moment.z}, .width_mm = 8};
  CLI::App* command = program.add_subcommand("torso-potential", "Electric potential of a dipole in the heart, in mV");
  command->add_option("mesh", mesh_path, "Tetrahedra of the torso (.vtu) with cell field \"region\"")->required();
  add_output(*command, output, "Mesh to write (.vtu), with the point field \"potential\"");
  command->add_option("--at", dipole.at_mm, "Position of the dipole, mm")->delimiter(',')->capture_default_str();
  command->add_option("--moment", dipole.moment_ma_mm, "Strength of the dipole, mA mm")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--width", dipole.width_mm, "Standard deviation of the smeared dipole, mm")
      ->capture_default_str();
  command->add_option("--torso", conductivities.torso, "Conductivity of the torso, S/m")->capture_default_str();
  command->add_option("--heart", conductivities.heart, "Conductivity of the heart, S/m")->capture_default_str();
  command->add_option("--lungs", conductivities.lungs, "Conductivity of the lungs, S/m")->capture_default_str();
  command->footer("Example:\n  rhoray-recipes torso-potential torso.vtu -o torso_potential.vtu");
  command->callback([] {
    preprocess::NeutralMesh mesh = preprocess::import_mesh(mesh_path);
    const auto conductivity = recipes::conductivity_of_cells(mesh, conductivities);
    recipes::PotentialReport solved = recipes::solve_potential(mesh, conductivity, dipole);
    const auto [lo, hi] = std::minmax_element(solved.potential_mv.begin(), solved.potential_mv.end());
    std::fprintf(stderr, "potential at %zu points: %.4g to %.4g mV, relative residual %.2e, %llu iterations\n",
                 mesh.points.size(), *lo, *hi, solved.residual,
                 static_cast<unsigned long long>(solved.iteration_count));
    mesh.length_unit = "mm";
    std::erase_if(mesh.point_fields, [](const auto& field) { return field.name == "potential"; });
    mesh.point_fields.insert(mesh.point_fields.begin(),
                             {.name = "potential",
                              .unit = "mV",
                              .component_count = 1,
                              .was_single_precision = false,
                              .values = {solved.potential_mv.begin(), solved.potential_mv.end()}});
    preprocess::export_mesh(mesh, output.path, output.replace_existing);
  });
}

void add_torso_ct(CLI::App& program) {
  static Output output;
  static std::string size = "256x256x256";
  CLI::App* command = program.add_subcommand("torso-ct", "Synthetic CT of the same torso, Hounsfield units as int16");
  add_output(*command, output, "Volume to write (.nhdr); the samples go beside it (.raw)");
  command->add_option("--size", size, "Samples on each axis; the Visible Woman has 512x512x1734")
      ->capture_default_str();
  command->footer("Example:\n  rhoray-recipes torso-ct -o torso_ct.nhdr --size 256x256x256");
  command->callback([] { recipes::write_torso_ct(output.path, parse_size(size), output.replace_existing); });
}

void add_torso_photo(CLI::App& program) {
  static Output output;
  static std::string size = "320x224x512";
  CLI::App* command =
      program.add_subcommand("torso-photo", "Synthetic photographs of the same torso's sections, 8-bit RGB");
  add_output(*command, output, "Volume to write (.nhdr); the colours go beside it (.raw)");
  command->add_option("--size", size, "Texels on each axis")->capture_default_str();
  command->footer(
      "Example:\n  rhoray-recipes torso-photo -o torso_photo.nhdr --size 320x224x512\n"
      "  rhoray pack torso_photo.nhdr --color -o torso_photo.rho");
  command->callback([] { recipes::write_torso_photo(output.path, parse_size(size), output.replace_existing); });
}

void add_marschner_lobb(CLI::App& program) {
  static Output output;
  static recipes::MarschnerLobbOptions options;
  static std::string type = "float";
  CLI::App* command = program.add_subcommand("marschner-lobb", "The test signal of Marschner and Lobb on [-1, 1]^3");
  add_output(*command, output, "Volume to write (.nhdr); the samples go beside it (.raw)");
  command->add_option("--size", options.size, "Samples on each axis")->capture_default_str();
  command->add_option("--type", type, "float (0 to 1) or uint8 (0 to 255)")
      ->check(CLI::IsMember({"float", "uint8"}))
      ->capture_default_str();
  command->footer("Example:\n  rhoray-recipes marschner-lobb -o ml41.nhdr --size 41");
  command->callback([] {
    options.as_bytes = type == "uint8";
    options.replace_existing = output.replace_existing;
    recipes::write_marschner_lobb(output.path, options);
  });
}

void add_test_volume(CLI::App& program, const std::string& name, recipes::TestVolume which, const std::string& about) {
  struct Settings {
    Output output;
    recipes::TestVolumeOptions options;
  };
  const auto settings = std::make_shared<Settings>();
  settings->options.which = which;
  CLI::App* command = program.add_subcommand(name, about);
  add_output(*command, settings->output, "Volume to write (.nhdr); the samples go beside it (.raw)");
  command->add_option("--size", settings->options.size, "Samples on each axis")->capture_default_str();
  command->footer("Example:\n  rhoray-recipes " + name + " -o " + name + ".nhdr --size 256");
  command->callback([settings] {
    settings->options.replace_existing = settings->output.replace_existing;
    recipes::write_test_volume(settings->output.path, settings->options);
  });
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is reported as an error of write
  CLI::App program("Make the surfaces, meshes and volumes for Rhoray's examples and measurements", "rhoray-recipes");
  program.require_subcommand(1);
  program.footer("Example:\n  rhoray-recipes torso-ct -o torso_ct.nhdr --size 64x64x64");
  add_torso_surface(program);
  add_torso_potential(program);
  add_torso_ct(program);
  add_torso_photo(program);
  add_marschner_lobb(program);
  add_test_volume(program, "smooth", recipes::TestVolume::smooth,
                  "A smooth body with a gyroid in it, 16 bit: isovalues 600.5 (skin) and 2200.5");
  add_test_volume(program, "turbulent", recipes::TestVolume::turbulent,
                  "Sheets upon sheets, 16 bit: isovalues 2048.5 and 2900.5");
  try {
    program.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::usage);
  } catch (const Error& error) {
    std::fprintf(stderr, "rhoray-recipes: %s\n", error.what());
    if (!error.hint().empty()) std::fprintf(stderr, "hint: %s\n", error.hint().c_str());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "rhoray-recipes: out of memory\n");
    return static_cast<int>(ErrorCode::resource);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rhoray-recipes: %s\n", error.what());
    return static_cast<int>(ErrorCode::internal);
  }
}
