// Draws isosurfaces of a mesh from its tetrahedra, and from grids and OpenVDB files on which its
// field was resampled. Measures the error against the exact answer of the mesh, the time of a
// picture, the time to resample, and the bytes.

#include "tools/lab/resample_or_direct.h"

#include <algorithm>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/read_value.h"
#include "preprocess/input_file.h"
#include "preprocess/pack_volume.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_spec.h"
#include "tools/analysis/cpu_meter.h"
#include "tools/analysis/data_forms.h"
#include "tools/lab/figures.h"
#include "tools/lab/judged_view.h"
#include "tools/lab/rounds.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"
#include "tools/validate/grid_field.h"

namespace rhoray::study {

namespace {

using tools::DataForm;

constexpr const char* table_name = "resample_or_direct";
constexpr const char* error_figure = "resample_or_direct_error";
constexpr const char* time_figure = "resample_or_direct_time";

// Kinds of rows, which are the curves of the figures.
constexpr const char* tetrahedra = "tetrahedra";
constexpr const char* grid_of_bricks = "grid, bricks of the mesh";
constexpr const char* whole_grid = "grid, whole box";
constexpr const char* openvdb = "OpenVDB";

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field, view = "front";
  std::vector<std::string> isovalues{"auto"};
  std::vector<std::string> sizes{"64", "128", "256", "512"}, whole_sizes{"64", "128", "256"},
      vdb_sizes{"64", "128", "256"};
  render::PictureSize size{512, 512};
  double judge_seconds = 60;
  std::uint64_t seed = 1;
  RoundsOptions rounds;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

/// Data from which the surface is drawn.
struct Form {
  std::string kind;
  int size = 0;  ///< samples on the longest axis; 0 for the mesh itself
  render::Dataset dataset;
  render::Method method{};
  double resample_cpu_s = 0;
  std::uint64_t bytes = 0;
  std::shared_ptr<const tools::ResampledBorder> border{};
};

std::vector<int> sizes_of(const std::string& option, const std::vector<std::string>& words) {
  std::vector<int> sizes;
  for (const std::string& word : words) {
    if (word == "none") continue;
    int size = 0;
    tools::read_value(word, size);
    require_within(option, size, 2, 4096);
    sizes.push_back(size);
  }
  return sizes;
}

/// All samples of the box, NaN outside the mesh, as in systems without sparse grids.
preprocess::NeutralVolume whole_samples(const render::Dataset& bricks) {
  const formats::BrickGrid grid(bricks.file());
  const formats::GridDescription& description = grid.description();
  const tools::validate::GridField field(grid, bricks.field().name);
  preprocess::NeutralVolume whole;
  whole.sample_count = description.layout.sample_count;
  whole.type = bricks.field().type;
  whole.world_from_grid = description.world_from_grid;
  whole.axes = description.axes;
  whole.length_unit = description.length_unit;
  whole.field_name = bricks.field().name;
  const Index3 n = whole.sample_count;
  formats::with_element_type(whole.type, [&]<class T>(T) {
    whole.owned_samples.resize(static_cast<std::size_t>(volume(n)) * sizeof(T));
    T* out = reinterpret_cast<T*>(whole.owned_samples.data());
    for (std::int64_t k = 0; k < n.z; ++k)
      for (std::int64_t j = 0; j < n.y; ++j)
        for (std::int64_t i = 0; i < n.x; ++i) *out++ = static_cast<T>(field.sample(i, j, k));
  });
  whole.samples = whole.owned_samples;
  return whole;
}

class Forms {
 public:
  Forms(const render::Dataset& mesh, const std::filesystem::path& folder) : copies_(mesh), options_{.folder = folder} {
    for (const char* level : {"float", "double", "certified"})
      all_.push_back({.kind = tetrahedra,
                      .dataset = mesh,
                      .method = render::method_of(render::accuracy_named(level)),
                      .bytes = mesh.file().file_bytes()});
    // Brings the mesh into memory, untimed.
    copies_.get({.kind = DataForm::Kind::resampled, .size = 2}, options_);
  }

  const std::vector<Form>& all() const { return all_; }

  void add(const std::string& kind, int size) {
    tools::CpuMeter meter;
    std::optional<render::Dataset> drawn;
    std::uint64_t bytes = 0;
    std::shared_ptr<const tools::ResampledBorder> border;
    const double cpu_s = meter
                             .measure([&] {
                               const tools::FormedData& copy = copies_.get(form_of(kind, size), options_);
                               drawn = copy.dataset;
                               bytes = copy.file_bytes;
                               border = copy.border;
                               if (kind == whole_grid) drawn = whole(copy.dataset, size, bytes);
                             })
                             .cpu_s;
    // The samples of the others are those of the bricks, which may exist already.
    const auto bricks = std::find_if(all_.begin(), all_.end(), [&](const Form& form) {
      return kind != grid_of_bricks && form.kind == grid_of_bricks && form.size == size;
    });
    const double before_s = bricks == all_.end() ? 0 : bricks->resample_cpu_s;
    all_.push_back({.kind = kind,
                    .size = size,
                    .dataset = *drawn,
                    .method = render::default_method(*drawn, render::Mode::isosurface),
                    .resample_cpu_s = before_s + cpu_s,
                    .bytes = bytes,
                    .border = border});
  }

 private:
  static DataForm form_of(const std::string& kind, int size) {
    return {.kind = kind == openvdb ? DataForm::Kind::resampled_vdb : DataForm::Kind::resampled, .size = size};
  }

  render::Dataset whole(const render::Dataset& bricks, int size, std::uint64_t& bytes) const {
    const std::filesystem::path path = options_.folder / concat("whole", size, ".rho");
    bytes = preprocess::pack_volume(whole_samples(bricks), path).file_bytes;
    return render::Dataset::load(path);
  }

  tools::DataForms copies_;
  tools::FormOptions options_;
  std::vector<Form> all_;
};

std::string method_word(const Form& form) {
  return render::option_of(form.method, render::Mode::isosurface, form.dataset.is_mesh()).word;
}

std::string name_of(const Form& form) {
  return form.size == 0 ? concat(form.kind, ", ", method_word(form)) : concat(form.kind, ", ", form.size);
}

double step_of(const Form& form, const Box3& box) {
  const Vec3 size = box.size();
  return std::max({size.x, size.y, size.z}) / (form.size - 1);
}

/// Rows of one isovalue: errors first, then times in rounds.
std::vector<Json> rows_of(const Settings& settings, const Forms& forms, double isovalue,
                          const std::function<void(const std::string&)>& tell) {
  const render::Dataset& mesh = forms.all()[0].dataset;
  tell(concat("isovalue ", isovalue, ", the exact answer"));
  ExactView view(mesh, {.isovalue = isovalue,
                        .camera = tools::study_camera(tools::study_view_named(settings.view), mesh, isovalue,
                                                      double{1} * settings.size.width / settings.size.height),
                        .size = settings.size,
                        .judge_seconds = settings.judge_seconds,
                        .seed = settings.seed});
  std::vector<Json> rows;
  std::vector<TimedRow> timed;
  for (const Form& form : forms.all()) {
    tell(concat("isovalue ", isovalue, ", errors of ", name_of(form)));
    const Shown shown{
        .dataset = form.dataset, .isovalue = isovalue, .method = form.method, .border = form.border.get()};
    Json row{
        {"isovalue", isovalue},
        {"data", form.kind},
        {"size", form.size},
        {"method", method_word(form)},
        {"step_in_cells", form.size == 0 ? Json(nullptr) : Json(step_of(form, mesh.bounds()) / view.cell_length())},
        {"bytes", form.bytes},
        {"resample_cpu_s", form.resample_cpu_s}};
    row.update(view.ray_errors(shown));
    row.update(view.picture_errors(shown));
    rows.push_back(std::move(row));
    timed.push_back({.name = name_of(form), .act = [&view, shown] { view.draw(shown); }});
  }
  run_rounds(timed, settings.rounds, [&](const std::string& what) { tell(concat("isovalue ", isovalue, ", ", what)); });
  const double direct_ms = timed[0].cpu_ms().median;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const tools::Spread ms = timed[r].cpu_ms();
    rows[r]["cpu_ms"] = ms.median;
    rows[r]["cpu_ms_min"] = ms.smallest;
    rows[r]["cpu_ms_max"] = ms.largest;
    rows[r]["over_direct"] = ms.median / direct_ms;
    // After this many pictures, the time to resample has been recovered.
    const double won_ms = direct_ms - ms.median;
    const bool pays = forms.all()[r].size != 0 && won_ms > 0;
    rows[r]["pictures_to_pay"] = pays ? Json(1e3 * forms.all()[r].resample_cpu_s / won_ms) : Json(nullptr);
  }
  return rows;
}

/// Errors of all isovalues over the grid's size, on which alone they depend, for the grids that
/// keep the mesh's bricks. Differences and times of the first isovalue.
std::vector<Figure> figures_of(const std::vector<Json>& rows) {
  const double first_isovalue = rows[0]["isovalue"];
  Figure error{.name = error_figure,
               .x = {"samples on the longest axis"},
               .y = {"depth error, cells of the mesh"},
               .curves = {}};
  Figure time{.name = time_figure,
              .x = {"CPU time of a picture, ms"},
              .y = {.label = "picture difference, root mean square of 255 levels", .least = 1e-3},
              .curves = {}};
  for (const char* kind : {tetrahedra, grid_of_bricks, whole_grid, openvdb}) {
    Curve against_time{kind, {}};
    for (const Json& row : rows) {
      if (row["data"] != kind || row["isovalue"] != first_isovalue) continue;
      const double size = row["size"];
      const std::string label = size == 0 ? std::string(row["method"]) : concat(size);
      against_time.points.push_back({row["cpu_ms"], row["rmse_of_255"], label});
    }
    time.curves.push_back(std::move(against_time));
  }
  for (const bool is_p99 : {false, true})
    for (const Json& first : rows) {
      if (first["data"] != tetrahedra || first["method"] != rows[0]["method"]) continue;
      Curve curve{
          concat("isovalue ", rounded(first["isovalue"], 6), is_p99 ? ", 99 % of pixels" : ", median"), {}, is_p99};
      for (const Json& row : rows) {
        const Json& depth = row[is_p99 ? "depth_p99_cells" : "depth_median_cells"];
        if (row["data"] == grid_of_bricks && row["isovalue"] == first["isovalue"] && depth.is_number())
          curve.points.push_back({row["size"], depth, {}});
      }
      error.curves.push_back(std::move(curve));
    }
  return {error, time};
}

int run(const Settings& settings) {
  require_publishable(settings.common, {table_name});
  require_publishable_figures(settings.common, {error_figure, time_figure});
  require_within("--repeat", settings.rounds.rounds, 1, 10'000);
  require_within("--judge-seconds", settings.judge_seconds, 0, 1e6);
  const std::vector<int> sizes = sizes_of("--grids", settings.sizes),
                         whole_sizes = sizes_of("--whole", settings.whole_sizes),
                         vdb_sizes = sizes_of("--vdb", settings.vdb_sizes);
  preprocess::require_input(settings.input);
  const render::Dataset mesh = tools::load_dataset(settings.input, settings.field);
  if (!mesh.is_mesh())
    throw Error(ErrorCode::usage,
                concat(settings.input.string(), ": found a grid; expected a packed mesh of tetrahedra"));
  tools::Table table{table_name, "A mesh's isosurface, from its tetrahedra and from resampled grids", {}, {}};
  {
    tools::ProgressDisplay display(settings.common);
    const tools::ScratchFolder scratch(settings.scratch);
    Forms forms(mesh, scratch.path());
    const auto add = [&](const char* kind, const std::vector<int>& of_sizes) {
      for (const int size : of_sizes) {
        display.show(concat("resampling: ", kind, ", ", size));
        forms.add(kind, size);
      }
    };
    add(grid_of_bricks, sizes);
    add(whole_grid, whole_sizes);
    add(openvdb, vdb_sizes);
    table.context = context_with({{"input", settings.input.filename().string()},
                                  {"field", mesh.field().name},
                                  {"view", settings.view},
                                  {"size", {settings.size.width, settings.size.height}},
                                  {"machine", render::name_of(render::chosen_machine())},
                                  {"repeat", settings.rounds.rounds},
                                  {"seed", settings.seed},
                                  {"length_unit", mesh.length_unit()}});
    for (const std::string& text : settings.isovalues)
      for (Json& row : rows_of(settings, forms, render::choose_isovalue(text, mesh.field()).value,
                               [&](const std::string& what) { display.show(what); }))
        table.rows.push_back(std::move(row));
  }
  publish(table, settings.common);
  publish(figures_of(table.rows), settings.common);
  return 0;
}

}  // namespace

tools::Subcommand resample_or_direct() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "resample-or-direct",
      .summary = "A mesh's isosurface from its tetrahedra, and from grids that it was resampled on",
      .examples = {"rhoray-study resample-or-direct torso.rho --iso p75 -o results",
                   "rhoray-study resample-or-direct torso.rho --iso p75 --grids 64 --whole none --vdb none"},
      .sections =
          {{.heading = "Notes",
            .entries =
                {{"",
                  "Errors are against the exact answer of the mesh. The figure of times shows the first isovalue."}}}},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed mesh of tetrahedra", settings->input)},
           tools::output_options(settings->common, "FOLDER for resample_or_direct.csv, .json and two figures (.svg)"),
           {tools::value_option("--iso", "V[,V]", "Isovalues, as in render; default auto", settings->isovalues),
            tools::value_option("--field", "NAME", "Field; default the first", settings->field),
            tools::value_option("--grids", "N[,N]",
                                "Samples on the longest axis of grids that keep the mesh's bricks; or none; default "
                                "64,128,256,512",
                                settings->sizes),
            tools::value_option("--whole", "N[,N]", "The same of grids of the whole box; default 64,128,256",
                                settings->whole_sizes),
            tools::value_option("--vdb", "N[,N]", "The same of OpenVDB files; default 64,128,256", settings->vdb_sizes),
            tools::value_option("--view", "NAME", "front, from-feet, close-up or inside; default front",
                                settings->view),
            tools::value_option("--size", "WxH", "Pixels; default 512x512", settings->size),
            tools::value_option("--judge-seconds", "S",
                                "Pixels are judged in random order until this time is over; default 60",
                                settings->judge_seconds),
            tools::value_option("--seed", "N", "Of that order; default 1", settings->seed),
            tools::value_option("--repeat", "N", "Rounds; default 5", settings->rounds.rounds),
            tools::value_option("--scratch", "FOLDER", "For the copies", settings->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
