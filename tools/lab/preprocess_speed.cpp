// The cost of reading, packing and resampling, compared with VTK and with a plain copy of the
// bytes, in one run.

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkResampleToImage.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVersion.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <map>

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "preprocess/resample.h"
#include "tools/analysis/measure.h"
#include "tools/analysis/table.h"
#include "tools/lab/preprocess_speed.h"
#include "tools/lab/study_run.h"
#include "tools/lab/warped_box.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/subcommand.h"
#include "tools/rhoray/cli/version.h"

namespace rhoray::study {
namespace {

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
  std::vector<std::string> meshes{"500000", "1000000"};
  std::vector<std::string> sizes{"128", "256"};
  std::int64_t volume_edge = 384;
  int repeat = 3;
};

/// CPU and wall seconds of the steps of one row, by the step's name.
struct Taken {
  double cpu = 0, wall = 0;
};
using Steps = std::map<std::string, Taken>;

/// Adds the time since the last call to a step.
class Clock {
 public:
  void add_to(Steps& steps, const std::string& step) {
    const double cpu = tools::usage_so_far().cpu_s, wall = watch_.seconds();
    steps[step].cpu += cpu - cpu_;
    steps[step].wall += wall - wall_;
    cpu_ = cpu;
    wall_ = wall;
  }

 private:
  tools::Stopwatch watch_;
  double cpu_ = tools::usage_so_far().cpu_s, wall_ = 0;
};

/// Turns the phases of a subcommand into steps.
class PhaseClock {
 public:
  explicit PhaseClock(Steps& steps) : steps_(steps) {}

  void next(const std::string& phase) {
    if (phase == phase_) return;
    if (!phase_.empty()) clock_.add_to(steps_, phase_);
    phase_ = phase;
  }
  Progress progress() {
    return [this](std::string_view phase, std::uint64_t, std::uint64_t) { next(std::string(phase)); };
  }

 private:
  Steps& steps_;
  Clock clock_;
  std::string phase_;
};

/// One row of the table: the action, its input, and the steps that it takes.
struct Row {
  std::string what, input, size;
  std::function<void(Steps&)> act;
  /// By step, and "total"; one entry for each repetition.
  std::map<std::string, std::vector<Taken>> taken{};
};

Row pack_row(const std::filesystem::path& mesh, const std::filesystem::path& scratch) {
  return {"rhoray pack", mesh.stem().string(), "", [=](Steps& steps) {
            PhaseClock clock(steps);
            clock.next("reading");
            const preprocess::NeutralMesh read = preprocess::import_mesh(mesh);
            preprocess::pack_mesh(read, scratch / "packed.rho", {.replace_existing = true}, clock.progress());
            clock.next("end");
          }};
}

Row resample_row(const std::filesystem::path& mesh, const std::string& size, const std::filesystem::path& scratch) {
  std::int64_t samples = 0;
  tools::read_value(size, samples);
  return {"rhoray resample", mesh.stem().string(), size, [=](Steps& steps) {
            PhaseClock clock(steps);
            clock.next("reading");
            const preprocess::NeutralMesh read = preprocess::import_mesh(mesh);
            preprocess::resample(read, scratch / "grid.rho",
                                 {.lattice = {.longest_axis = samples}, .replace_existing = true}, clock.progress());
            clock.next("end");
          }};
}

Row vtk_row(const std::filesystem::path& mesh, const std::string& size) {
  int samples = 0;
  tools::read_value(size, samples);
  return {"vtkResampleToImage", mesh.stem().string(), size, [=](Steps& steps) {
            Clock clock;
            vtkNew<vtkXMLUnstructuredGridReader> reader;
            reader->SetFileName(mesh.c_str());
            reader->Update();
            clock.add_to(steps, "reading");
            vtkNew<vtkResampleToImage> resample;
            resample->SetInputDataObject(reader->GetOutput());
            resample->SetSamplingDimensions(samples, samples, samples);
            resample->Update();
            clock.add_to(steps, "resampling");
            if (resample->GetOutput()->GetPointData()->GetArray("value") == nullptr)
              throw Error(ErrorCode::internal, "vtkResampleToImage: found no array 'value' in its output");
          }};
}

/// Bytes of a slowly varying 16-bit volume.
void write_raw(const std::filesystem::path& path, std::int64_t edge) {
  std::ofstream file(path, std::ios::binary);
  std::vector<std::uint16_t> layer(static_cast<std::size_t>(edge * edge));
  for (std::int64_t k = 0; k < edge; ++k) {
    for (std::size_t s = 0; s < layer.size(); ++s)
      layer[s] = static_cast<std::uint16_t>((s * 7 + static_cast<std::size_t>(k) * 131) >> 4);
    file.write(reinterpret_cast<const char*>(layer.data()),
               static_cast<std::streamsize>(layer.size() * sizeof layer[0]));
  }
  file.flush();
  if (!file) throw Error(ErrorCode::resource, concat(path.string(), ": could not be written"));
}

Row pack_volume_row(const std::filesystem::path& raw, std::int64_t edge, const std::filesystem::path& scratch) {
  return {"rhoray pack", raw.stem().string(), "", [=](Steps& steps) {
            PhaseClock clock(steps);
            clock.next("reading");
            preprocess::ImportVolumeOptions options;
            options.raw =
                preprocess::RawVolume{.sample_count = Index3(edge, edge, edge), .type = formats::ElementType::U16};
            const preprocess::NeutralVolume volume = preprocess::import_volume(raw, options);
            preprocess::pack_volume(volume, scratch / "volume.rho", {.replace_existing = true}, clock.progress());
            clock.next("end");
          }};
}

/// Reads and writes a megabyte at a time.
Row copy_row(const std::filesystem::path& raw, const std::filesystem::path& scratch) {
  return {"copy of the bytes", raw.stem().string(), "", [=](Steps& steps) {
            Clock clock;
            std::ifstream from(raw, std::ios::binary);
            std::ofstream to(scratch / "copy.raw", std::ios::binary);
            std::vector<char> buffer(std::size_t{1} << 20);
            while (from.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), from.gcount() > 0)
              to.write(buffer.data(), from.gcount());
            to.flush();
            if (!to) throw Error(ErrorCode::resource, "the copy could not be written");
            clock.add_to(steps, "copying");
          }};
}

std::vector<Row> rows_of(const Settings& settings, const std::filesystem::path& scratch) {
  std::vector<Row> rows;
  for (const std::string& wanted : settings.meshes) {
    std::uint64_t cell_count = 0;
    tools::read_value(wanted, cell_count);
    const preprocess::NeutralMesh mesh = warped_box(edge_for(cell_count));
    const std::filesystem::path path = scratch / concat(mesh.cells.size(), "_tetrahedra.vtu");
    preprocess::export_mesh(mesh, path, true);
    rows.push_back(pack_row(path, scratch));
    for (const std::string& size : settings.sizes) {
      rows.push_back(resample_row(path, size, scratch));
      rows.push_back(vtk_row(path, size));
    }
  }
  if (settings.volume_edge > 0) {
    const std::int64_t edge = settings.volume_edge;
    const std::filesystem::path raw = scratch / concat("volume_", edge, "x", edge, "x", edge, "_uint16.raw");
    write_raw(raw, edge);
    rows.push_back(pack_volume_row(raw, edge, scratch));
    rows.push_back(copy_row(raw, scratch));
  }
  return rows;
}

/// Runs every row once, then again, so that other load on the machine affects all of them.
void measure(std::vector<Row>& rows, int repeat) {
  for (int round = 0; round < repeat; ++round)
    for (Row& row : rows) {
      std::fputs(
          concat("round ", round + 1, " of ", repeat, ": ", row.what, " ", row.input, " ", row.size, "\n").c_str(),
          stderr);
      Steps steps;
      row.act(steps);
      Taken total;
      for (const auto& [step, taken] : steps) {
        row.taken[step].push_back(taken);
        total.cpu += taken.cpu;
        total.wall += taken.wall;
      }
      row.taken["total"].push_back(total);
    }
}

Json context(const Settings& settings) {
  return context_with({{"memory_bytes", tools::this_machine().memory_bytes},
                       {"vtk", vtkVersion::GetVTKVersion()},
                       {"repeat", settings.repeat}});
}

tools::Table table_of(const std::vector<Row>& rows, const Settings& settings) {
  tools::Table table{"preprocess_speed", "Seconds of packing and resampling, medians", context(settings), {}};
  for (const Row& row : rows)
    for (const auto& [step, taken] : row.taken) {
      std::vector<double> cpu, wall;
      for (const Taken& once : taken) {
        cpu.push_back(once.cpu);
        wall.push_back(once.wall);
      }
      const tools::Spread spread = tools::spread_of(cpu);
      table.rows.push_back({{"what", row.what},
                            {"input", row.input},
                            {"size", row.size},
                            {"step", step},
                            {"cpu_s", spread.median},
                            {"cpu_s_smallest", spread.smallest},
                            {"cpu_s_largest", spread.largest},
                            {"wall_s", tools::spread_of(wall).median}});
    }
  return table;
}

int run(const Settings& settings) {
  require_within("--repeat", settings.repeat, 1, 1000);
  require_within("--volume", static_cast<double>(settings.volume_edge), 0, 4096);
  require_publishable(settings.common, {"preprocess_speed"});
  const tools::ScratchFolder scratch(settings.scratch);
  std::vector<Row> rows = rows_of(settings, scratch.path());
  measure(rows, settings.repeat);
  const tools::Table table = table_of(rows, settings);
  publish(table, settings.common);
  return 0;
}

}  // namespace

tools::Subcommand preprocess_speed() {
  const auto settings = std::make_shared<Settings>();
  return {.name = "preprocess-speed",
          .summary = "Packing and resampling beside VTK and a plain copy of the bytes",
          .examples = {"rhoray-study preprocess-speed --meshes 500000 --sizes 128,256 -o results"},
          .options = {tools::value_option("-o,--output", "FOLDER", "For preprocess_speed.csv and .json",
                                          settings->common.output),
                      tools::flag_option("--force", "Replace files that are there", settings->common.force),
                      tools::value_option("--scratch", "FOLDER", "For files that are written to be timed",
                                          settings->scratch),
                      tools::value_option("--meshes", "N[,N]", "Numbers of tetrahedra", settings->meshes),
                      tools::value_option("--sizes", "N[,N]", "Samples on an axis", settings->sizes),
                      tools::value_option("--volume", "N", "Edge of the volume of N^3 samples; 0 leaves it out",
                                          settings->volume_edge),
                      tools::value_option("--repeat", "N", "Rounds; default 3", settings->repeat)},
          .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
